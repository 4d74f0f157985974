"""Track: records of sensors become ``Track``s, and a tracker may lead the autopilot.

``prior`` is what is known at the start, ``clutter`` a tracker among false plots, ``setup`` a tracker of a scenario with
all that it is given. ``batching`` runs trackers as one that differ only in their law, ``look_ahead`` asks how far
they can be believed, ``tracking_run`` tracks a flight with all of them; ``navigator`` closes the loop through one, and
``trial`` is a small flight on which the contract of a class is tried.
"""
