"""Fly: a ``Scenario`` is prepared (route, law, aircraft, air) and flown in closed loop to a ``Flight``."""
