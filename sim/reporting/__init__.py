"""What a run leaves for people: one HTML page with its figures."""
