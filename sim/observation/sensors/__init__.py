"""Kinds of sensors: a file here is the ``kind`` of ``[sensors.NAME]``; its contract is `sim.observation.sensor`."""
