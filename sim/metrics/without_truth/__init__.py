"""Figures of tracks without a truth: ``innovations`` of plots, ``predicted`` plots, ``agreement`` of trackers."""
