"""Processes: pools and clusters for many flights, a child for models that may abort, a helper for a part of a run."""
