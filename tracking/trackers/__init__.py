"""Kinds of trackers: a file here is the ``kind`` of ``[trackers.NAME]``; its contract is `tracking.track.Tracker`."""
