"""Words of the page.

``labels`` turn names with unit suffixes into words and numbers into digits; ``header`` is the first screen, with
``outcome_sentence``, ``contrast_sentence``, which has its ``reasons`` from the flight, and ``best_tracker``; ``rows``
and ``tracker_tables`` are its tables; ``references`` are the equations, papers and errata of what ran; ``warnings`` are
what a reader should know of sensors and trackers besides; ``broken_checks`` says of each check that failed how, and
which command flies that flight again.
"""
