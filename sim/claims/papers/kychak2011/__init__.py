"""Kychak 2011: two hypotheses on the accuracy of every measured angle, and anomalies that come in bursts.

``experiment`` draws anomalies, on its own model and on flown glide paths, ``cheaper`` counts what other filters cost;
``claims`` measures, ``figures`` redraws figures 3 to 5 and 8 to 10 and draws accuracy against operations.
"""
