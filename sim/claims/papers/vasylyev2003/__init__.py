"""Vasylyev 2003: the autopilot as a linear feedback inside the model, or as a saturated control outside the filter.

``experiment`` captures a line, in the double integrator and on JSBSim; ``approaches`` has the turns and straights of
whole landing patterns, ``beacon`` the radio-beacon law. ``claims`` measures on them; ``figures`` redraws figures 3
and 4.
"""
