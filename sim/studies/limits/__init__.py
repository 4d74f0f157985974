"""Limit studies: where the limits of a route law begin to act on a capture, and what that costs a tracker.

``capture`` follows a capture of a line and both filters of it without noise, for many cases at once; ``prediction``
reads the cases from a scenario. ``maps`` are the ratios of a flown study as plain values, with the borders of theory;
``answer`` says them in one sentence, ``drawing`` draws them. ``bisection`` finds where a figure passes a limit.
"""
