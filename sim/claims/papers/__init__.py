"""One folder for each paper.

``claims`` are its sentences with all their readings, ``experiment`` what measures them, ``figures`` its figures redrawn
from our own runs.
"""
