"""Formats of others, as plain arrays, in and out.

``track_record`` is a recorded track as it lies in files, ``track_writer`` writes a file of them, ``tracks`` reads one:
``tables`` gives its columns, ``columns`` says which of ours they are and in which units, ``stamps`` reads times and
numbers. ``plots`` are recorded plots of a radar, ``clocks`` says when they were made.
"""
