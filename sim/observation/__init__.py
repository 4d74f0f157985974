"""Observe: sensors watch a ``Flight``, each with a ``SensorRecord`` of its looks.

``sensor`` is the contract of a sensor, ``antenna`` what several share, ``record`` the loop over a recorded flight,
``faults`` makes a sensor err more than it states, ``as_recorded`` turns a flight into the rows of a recording and
``recordings`` brings recorded looks to the date of a flight;
``sensors`` is the catalogue, one file for each kind.
"""
