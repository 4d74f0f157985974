"""Results: what a run found out, and its folder.

``result`` is the answer of ``sim.run``, ``studied`` that of ``sim.study``; ``saving`` writes the files of a run that
programs read, ``loading`` makes the result of them again, `asterix` writes plots and tracks for the radars of others,
``judging`` brings tracks of others back beside ours. ``globe`` shows a run on a globe, ``replaying`` in a FlightGear,
``stonesoup`` hands it to Stone Soup and back; ``estimates`` is what a tracker took for the aircraft, draw by draw.
"""
