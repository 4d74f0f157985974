"""Prepare: all that one flight needs (``prepared``), from a scenario.

``flown`` prepares one that is flown here, ``recorded`` one that was flown elsewhere.

``aircraft`` is what flies, ``configuration`` its flaps and landing with what is said of its limits, ``loops`` the gains
of its inner loops, ``law`` the law above them, ``start`` where the flight begins. What depends on the kind of route is
asked of that (``sim.flight.routes``).
"""
