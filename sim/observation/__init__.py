"""Observe: sensors watch a ``Flight``, each with a ``SensorRecord`` of its looks.

``sensor`` is the contract of a sensor, ``antenna`` what several share, ``record`` the loop over a recorded flight,
``recordings`` brings recorded looks to the date of a flight, ``faults`` makes a sensor err more than it states;
``sensors`` is the catalogue, one file for each kind.
"""
