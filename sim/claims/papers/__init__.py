"""One folder for each paper: its claims, the experiments that measure them, and its figures redrawn."""
