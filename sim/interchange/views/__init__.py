"""Flights as other people's viewers take them: a KMZ for a globe, packets for FlightGear. Plain arrays in, bytes out.

``kmz`` writes tracks over the time of day, ``flightgear`` the packets from which a FlightGear shows an aircraft.
"""
