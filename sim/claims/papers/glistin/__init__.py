"""Glistin, Panasyuk: the azimuth aided by downlinked load factors."""
