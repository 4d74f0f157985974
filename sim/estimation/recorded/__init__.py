"""Tracks that a tracker made elsewhere, judged beside ours.

``kind`` is the tracker of a scenario that brings its estimates from a file, ``chain`` makes of its rows one estimate
for each epoch and draw, ``judged`` its figures, and ``completeness`` says how whole the track is.
"""
