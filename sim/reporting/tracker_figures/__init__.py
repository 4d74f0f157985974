"""Figures of the trackers; ``charts`` calls them in the order in which a reader asks.

``error_curves`` are the numbers behind them, ``path_bound`` a line of reference. ``tracking_errors``, ``estimate_map``,
``model_probabilities`` and ``conformance_strip`` draw.
"""
