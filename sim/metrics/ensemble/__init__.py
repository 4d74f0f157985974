"""What several flights show together, from the plain record of each.

``spread`` counts how they ended and where their figures lie, ``trackers`` has the figures of a tracker over all of
them and ``contrasts`` those of two trackers against each other, ``exceedance`` how often they go beyond limits,
``verdict`` is what a check comes to: the one verdict of runs, studies, tests and pages.
"""
