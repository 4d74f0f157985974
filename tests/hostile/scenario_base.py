"""The shortest flight that there is, which hostile models fly and mutations change."""

CAPTURE = """
name = "short"
draws = 1
until_s = 2
[route]
kind = "legs"
[[route.legs]]
from_m = [0, 0]
to_m = [20000, 0]
speed_mps = 72
height_m = 600
[start]
leg = 0
cross_track_m = 30
[sensors.radar]
kind = "surveillance_radar"
period_s = 0.5
[trackers.steady]
kind = "kalman"
"""
