"""Figures of a track that need no truth: ``innovations`` of its plots, ``predicted`` plots, ``agreement`` of trackers."""
