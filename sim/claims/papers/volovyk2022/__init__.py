"""Volovyk 2022: interacting multiple models in the azimuth channel of a precision approach radar.

``landing_paths`` are the patterns that the radar sees, ``filters`` what watches them: sets of models, and the rivals
that the paper names, ``tuning`` how their densities were found. ``experiment`` runs them, ``norms`` holds the angle
against what is regulated, ``cost`` counts and times; ``claims`` measures, ``figures`` redraws figures 1 to 4.
"""
