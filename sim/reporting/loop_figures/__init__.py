"""Figures of the linear loops of a scenario: ``bode`` of the route loop, ``step`` of bank loop and route loop."""
