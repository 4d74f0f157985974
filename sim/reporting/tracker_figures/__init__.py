"""Figures of the trackers; ``charts`` calls them in the order in which a reader asks.

``error_curves`` gives each tracker its look, ``path_bound`` a line of reference, ``parting`` says where two trackers
part. ``contrast_map``, ``tracking_errors``, ``estimate_map``, ``model_probabilities``, ``conformance_strip``,
``monitor_strip`` and ``operating_curves`` draw.
"""
