"""Tracks of which no truth is known: plots alone begin them, and plots alone judge them.

``places`` brings plots to the ground plane, ``two_plots`` begins a track, ``predicted_plots`` looks ahead to later
ones, ``judged`` puts the figures together.
"""
