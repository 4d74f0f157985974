"""Two trackers set against each other: by how much the errors of one exceed those of the other.

``squares`` are what is kept of a tracker that is contrasted, ``pairing`` sets two of them against each other on one
flight and says how; over several flights it is ``sim.metrics.ensemble.contrasts``.
"""
