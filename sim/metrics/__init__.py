"""Judge: signals and figures of a flight, errors of a tracker, and the checks that hold them against limits."""
