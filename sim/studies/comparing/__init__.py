"""Two runs, or two studies, set against each other: what changed beyond noise, and beyond a tolerance.

- ``comparison`` - the verb, its rows and its method
- ``sides`` - the records of flights of a run, of a study or of a result
- ``spans`` - differences with simultaneous intervals
- ``told`` - a comparison as text
- ``tolerance`` - the file that says how far metrics may move
"""
