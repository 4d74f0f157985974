"""MADAP, an outside judge: the published errors of operational trackers beside those of ours.

``experiment`` flies its sixteen manoeuvres, seen by one radar or by several; ``claims`` measures, ``figures`` shows the
flights.
"""
