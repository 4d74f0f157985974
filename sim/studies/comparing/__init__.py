"""Two runs, or two studies, set against each other: what changed beyond noise, and beyond a tolerance.

- ``comparison`` - the verb, its rows and its method
- ``judging`` - whether anything changed, and which metrics, all of them together
- ``arrangements`` - how the flights could lie on the two sides as well
- ``evidence`` - what one metric says, in each arrangement
- ``sides`` - the records of flights of a run, of a study or of a result
- ``spans`` - differences with intervals that hold together
- ``told`` - a comparison as text
- ``tolerance`` - the file that says how far metrics may move
"""
