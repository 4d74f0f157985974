"""Volovyk 2018: the Kalman filter of the MLS elevation channel and what its realisations cost."""
