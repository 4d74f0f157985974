"""Track: records of sensors become ``Track``s, and a tracker may lead the autopilot."""
