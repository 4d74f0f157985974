"""What a run leaves as ASTERIX: ``files`` writes them, of messages that ``sensors`` and ``trackers`` make."""
