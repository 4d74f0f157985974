"""Formats of others, as plain arrays, in and out.

``track_record`` is a recorded track as it lies in files, ``tracks`` reads a file of them and ``track_writer`` writes
one: ``tables`` gives the columns of a file, ``columns`` says which of ours they are and in which units, ``stamps``
reads times and numbers. ``plots`` are recorded plots of a radar, ``estimates`` those of a tracker: ``cells`` reads
their tables by the names of columns, ``clocks`` says when they were made. `asterix` is the format of surveillance data,
`views` are a KMZ and packets for FlightGear.
The room ``jsbsim_system`` writes functions of Python as a system of JSBSim.
"""
