"""Vasylyev 2003: the autopilot as a linear feedback inside the model, or as a saturated control outside the filter.

``experiment`` captures a line, in the double integrator and on JSBSim; ``claims`` measures on it, ``figures`` redraws
figures 3 and 4.
"""
