"""Estimation: Kalman algebra, motion and measurement models, trackers, their consistency and their bounds.

NumPy and SciPy only, and nothing of aeroplanes: a law or a route is handed in by whoever knows it. The plane is
(x, y) = (north, east), so a positive turn rate turns right. Matrix axes come first, batch axes last.

- ``gaussian``: all Kalman algebra; ``packed``: mixtures of many runs as one array; ``motion``, ``integrators``: F, Q
  and inputs; ``measurement``: z = H x + v; ``partial_place``: the same of sensors that give a place only together;
  ``height_profile``: heights from a chart
- ``track``: what trackers are given and give, and the only loop over time; ``contract``: what tries a class on it
- ``trackers``: one file for each kind; ``reference_path``: the path of those that know a law, ``law_bank`` several laws
  side by side, ``vectored_switching`` where laws are taken up under vectors, ``azimuth_acceleration`` the algebra of
  those that know load factors
- ``association``: among false plots; ``schedule``: gains computed once; ``smoothing``: with what came later;
  ``tree``: the state of a tracker over runs and hypotheses; ``filterpy_adapter``: filters of a user's own
- ``consistency``, ``monitor``, ``conformance``: is it as good as it says, does it still follow, is the law flown;
  ``intervals``: values with their confidence; ``bounds``, ``reference_filter``: what no tracker can beat;
  ``operations``: what a filter costs
"""
