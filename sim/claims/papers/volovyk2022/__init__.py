"""Volovyk 2022: interacting multiple models in the azimuth channel of a precision approach radar."""
