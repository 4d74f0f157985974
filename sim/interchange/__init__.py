"""Formats of others, as plain arrays, in and out.

``track_record`` is a recorded track as it lies in files, ``track_writer`` writes a file of them.
"""
