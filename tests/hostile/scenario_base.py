"""The shortest flight that there is, which hostile models fly and mutations change."""

from tests.capture import capture

CAPTURE = capture(
    """
[sensors.radar]
kind = "surveillance_radar"
period_s = 0.5
[trackers.steady]
kind = "kalman"
""",
    name="short",
    draws=1,
    until_s=2,
    cross_track_m=30,
)
