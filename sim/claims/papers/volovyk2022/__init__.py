"""Volovyk 2022: interacting multiple models in the azimuth channel of a precision approach radar.

``landing_paths`` are the patterns that the radar sees, ``experiment`` the sets of models on them; ``claims`` measures,
``figures`` redraws figures 1 to 4.
"""
