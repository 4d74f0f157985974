"""Kychak 2011: angle measurements of varying accuracy, two and N hypotheses."""
