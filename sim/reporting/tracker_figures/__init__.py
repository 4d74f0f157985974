"""Figures of the trackers: errors, beliefs, bounds and alarms, along the flight and on the map."""
