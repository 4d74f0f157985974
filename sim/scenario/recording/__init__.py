"""What a scenario says of recordings: ``record_table`` instead of a flown flight, ``plots_alone`` where none is known.

``places`` makes the names of their files absolute, so that a resolved scenario is run from anywhere.
"""
