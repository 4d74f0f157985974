"""Alarms of tests that watch a tracker, against when something went wrong.

``detection`` parts alarms into false ones and answers, ``monitoring`` has the figures of the monitor of innovations,
``operating_curve`` sweeps the threshold of a test: its delay over its false alarms.
"""
