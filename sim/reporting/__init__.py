"""Report: what a run leaves for people and for other programs.

``run_page`` is the HTML page of a run, with ``templates`` for its frame, ``text`` for words and tables, ``figures`` of
the flight, ``tracker_figures``, and ``replay`` for what moves; ``run_files`` are the arrays of the run with units in
their names.
"""
