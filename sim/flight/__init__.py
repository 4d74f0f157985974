"""Fly: a ``Scenario`` is prepared and flown in closed loop to a ``Flight``.

``vehicles`` are what flies, ``weather`` is the air, ``departures`` what a crew does instead of the law, ``airspeeds``
the margins of the speeds over the stall, ``gains`` the design of the loops, made or carried by a file; ``preparation``
joins them with route, law and trim, with the parts that lie in ``preparing`` and the kinds of route in ``routes``.
``loop`` flies, ``outcomes`` says how it ends, ``record`` is the ``Flight``, ``interpolation`` the motion between its
instants.
``swings`` what theory says of them. The room ``arrivals`` has approaches as they are flown, ``truths`` are flights by
formula, one file for each path of the papers, ``recording`` makes one of a recorded track,
``jsbsim_root`` a scenario that JSBSim flies alone, ``linear_systems`` its loops for python-control.
"""
