"""A recorded track becomes a ``Flight``: cleaned, brought to the runway, smoothed, its phases found.

``places`` brings latitude, longitude and pressure altitude to the frame of the runway, ``cleaning`` takes out the rows
that say nothing and cuts the record at gaps, ``smoothing`` gives place, velocity and acceleration without the jitter,
``phases`` says how the approach was flown. ``flight`` does it all for one track, ``flights`` for a file of them.
``notes`` says what its user should know of it; ``unknown`` is a flight that only plots tell of.
"""
