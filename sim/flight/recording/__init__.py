"""Flights that were recorded: ``unknown`` is one that only plots tell of."""
