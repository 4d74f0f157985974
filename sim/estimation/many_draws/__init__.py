"""Ensembles of more draws than go through a tracker at once: part by part, with bounded memory.

``filed_array`` is an array in a file, ``collected`` puts tracks and errors of the parts together.
"""
