"""What to fly, and how to hold it: from a route to the controls.

A route gives the deviation from a leg, a law turns it into a bank command, the approach orders heights, speeds, flaps
and gear by phases, and the inner loops turn the commands into controls. ``begin`` gives a state and ``step`` passes it
on; nothing is remembered elsewhere, so the same text of a law also serves trackers that predict the aircraft.

- ``route``: legs, deviations, wind-aware turns; ``saturation``: the limiting functions of the laws
- ``modes``: one file per law, a pure function of the deviation with its own limits; ``mode``: the contract of a law
- ``approach``, ``landing``, ``stabilised_gate``: the phases from downwind to the ground, or around again;
  ``departure``: an autopilot that is not flown to the end; ``vectored``: headings that are held until the law takes
  over; ``planned_heights``: the heights that will be ordered
- ``identification``: which law flew a ``capture`` (``law_search`` finds it); ``last_turn``: the turn onto a leg, found
- ``rollout``: brakes and steering to a stop after a landing
- ``inner_loops``: Command -> Controls with the gains of ``design``, which come from the linear model of the aircraft
- ``analysis``: poles and predictions of the route law, its phase portrait
- ``route_loop``: its margins; ``linear_systems``: the loops for python-control, with names;
  ``estimate_lag``: those on an estimate; ``disk_margin``: those of the inner loops
- ``limit_cycles``, ``describing_functions``, ``cycle_waves``: what the limits of the law sustain; ``swing_margin``: a
  law slow enough for them to sustain nothing

Knows the airframe only by what passes between them, ``aircraft.state`` and ``aircraft.units``.
"""
