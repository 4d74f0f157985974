"""Functions of Python as a system of JSBSim: one text, which both fly.

``translation`` walks the syntax tree of a function, statement by statement, ``expressions`` what is within one, each in
a ``scope``. What is known in flight only is one of ``terms``; ``values`` are what a variable may hold, ``operators``
and ``functions`` what can be done with it. ``components`` writes terms as ``fcs_function`` elements. Nothing here knows
what is translated.
"""
