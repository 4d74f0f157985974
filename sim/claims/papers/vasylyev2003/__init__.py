"""Vasylyev 2003: the autopilot as a linear feedback inside the model, or as a saturated control outside the filter."""
