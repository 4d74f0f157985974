"""The figures of the papers, from our own runs."""
