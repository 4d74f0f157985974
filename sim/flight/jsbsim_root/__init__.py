"""A scenario as a root of JSBSim, which then flies it alone: aircraft, system, initial conditions, script.

``crew`` is all that acts at one step of the autopilot, in Python as here; ``system`` is the same text, translated by
the room ``interchange``; ``script`` starts and ends the flight; ``folder`` joins them.
"""
