"""Observe: sensors watch a ``Flight``; each has a ``SensorRecord`` of its looks."""
