"""Laws identified: the route law that flew each capture of a file of recordings, or of a run.

``captures`` finds the capture in a flight (the verb ``sim.identify``), ``survey`` does so for many, ``spread`` says
what they have in common; ``sources`` reads the flights, ``law_file`` writes what a scenario can fly, ``figures`` and
``page`` show it, and ``command`` does all of it.
"""
