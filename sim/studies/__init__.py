"""Many flights: a scenario over the axes of its ``[study]`` table, crash-safe.

``plan`` lists the flights, ``job`` is one of them in a worker, ``folder`` says whose study a folder is, and ``kept``
has what it keeps of finished flights; ``study`` runs it, ``studied`` from Python. ``metrics`` are its figures for each
cell, ``theory`` predicts limits without flying, ``limits`` has more of them; ``figures`` and ``page`` show them.
``convergence`` is the rate of an aircraft's equations of motion. ``recordings`` writes the flights of a folder as
recordings of traffic, ``identification`` finds the laws that flew.
"""
