"""Volovyk 2018: the Kalman filter of the MLS elevation channel and what its realisations cost.

``experiment`` runs the filter on its own model, on the level leg of the paper and on those of JSBSim,
``initial_values`` looks where the printed start can hold, ``word_length`` rounds; ``claims`` measures, ``figures``
redraws figures 1, 2, 4 and 5.
"""
