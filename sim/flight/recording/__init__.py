"""A recorded track becomes a ``Flight``: cleaned, brought to the runway, smoothed, its phases found.

``units`` finds columns that contradict each other; ``places`` brings latitude, longitude and pressure altitude to the
frame of the runway; ``cleaning`` takes out the rows that say nothing and cuts the record at gaps; ``smoothing`` gives
place, velocity and acceleration without the jitter; ``phases`` says how the approach was flown, and ``notes`` what does
not fit. ``flight`` does it all for one track, ``flights`` for a file of them.
``unknown`` is a flight that only plots tell of.
"""
