"""Formats of others, as plain arrays, in and out.

``track_record`` is a recorded track as it lies in files, ``plots`` are recorded plots of a radar, ``clocks`` says when
either was.
"""
