"""Figures of a flight: each is a function that draws one chart of the page."""
