"""Track: records of sensors become ``Track``s, and a tracker may lead the autopilot.

``prior`` is what is known at the start, ``clutter`` a tracker among false plots, ``setup`` builds a tracker of a
scenario, ``own_trackers`` one that the caller brings. ``batching`` runs trackers as one that differ only in law or
noise, ``many_draws`` keeps what large ensembles leave, ``look_ahead`` measures how far ahead their prediction is good,
``tracking_run`` tracks a flight with all of them, of the parts in ``tracked``; ``recorded`` are tracks that were made
elsewhere. ``assumed_height`` says what an unmeasured height cost, ``navigator`` closes the loop through a tracker,
``navigation_errors`` through an autopilot's own sensors, and ``trial`` is a small flight for testing the contract of a
class.
"""
