"""Figures of a flight, one function each; ``flight`` calls them in the order of the page.

``plan_view``, ``vertical_profile``, ``histories`` (bank, speed, airframe, deviations), ``phase_portrait``,
``weather`` and ``measurements`` draw; ``style`` is how all figures look, ``curves``,
``deviations`` and ``thinning`` are what several share.
"""
