"""Kinds of wind events: a file here is the ``kind`` of ``[wind.events.NAME]``; its contract is `aircraft.wind_event`.

``_occasion`` is no kind: it is what several share.
"""
