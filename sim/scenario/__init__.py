"""Read: a TOML file becomes a validated ``Scenario``, all its faults told at once.

``tables`` are the tables of a file as parameter classes and ``parameters`` the one mechanism between a key with its
unit and a field in SI; ``catalogue`` finds the kinds, ``plugins`` those brought from outside; ``schema`` is the model
of a whole file, ``axes`` that of a study, ``messages`` puts faults into the user's words. ``reading`` does it all,
``model`` is what comes out; ``budget`` refuses what is too much for the machine, ``toml_writer`` writes a scenario
back. The room ``arrivals`` has the tables of approaches as they are flown, ``bundled`` holds the scenarios and studies
that come with the program.
"""
