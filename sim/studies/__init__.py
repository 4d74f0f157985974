"""Many flights: a scenario over the axes of its ``[study]`` table, crash-safe.

``plan`` is what is flown, ``job`` one flight of it in a worker, ``flight_cache`` lets cells share flights, ``folder``
keeps what is done; ``study`` runs it. ``metrics`` are its figures for each cell, ``theory`` the borders that are known
beforehand; ``figures`` and ``page`` show them. ``bisection`` finds where a figure passes a limit.
"""
