"""The parts of tracking a flight.

``watch`` is what all trackers share and what each takes in, ``beginning`` when a track begins and with what, ``parts``
gathers tracks and errors of some draws after others, ``outcome`` is what is kept of a tracker.
"""
