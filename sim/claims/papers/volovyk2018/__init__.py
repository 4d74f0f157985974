"""Volovyk 2018: the Kalman filter of the MLS elevation channel and what its realisations cost.

``experiment`` runs the filter on its own model, on the level leg of the paper and on that of JSBSim; ``claims``
measures, ``figures`` redraws figures 1, 2, 4 and 5.
"""
