"""Estimation: Kalman algebra, motion and measurement models, trackers, their consistency and their bounds.

NumPy and SciPy only, and nothing of aeroplanes: a law or a route is handed in by whoever knows it. The plane is
(x, y) = (north, east), so a positive turn rate turns right. Matrix axes come first, batch axes last.
"""
