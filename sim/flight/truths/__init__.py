"""The papers' kinematic truths as Flights, one file each.

A truth is a frozen dataclass whose ``fly()`` gives the record that a JSBSim flight gives, so sensors, trackers and
metrics need not know which it is. Those that follow a law are flown by the point mass, step by step; those whose path
is prescribed are in closed form, with load factors and rates that are exactly those of the path. The air is calm unless
a truth has a wind. Positions are from the origin of the runway frame, where the papers' antennas are unless a truth
says otherwise.
"""
