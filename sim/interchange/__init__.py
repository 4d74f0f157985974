"""Formats of others, as plain arrays, in and out.

``track_record`` is a recorded track as it lies in files, read by ``tracks`` from ``tables`` with known ``columns`` and
``stamps``. ``plots`` are recorded plots of a radar, ``clocks`` says when they were made.
"""
