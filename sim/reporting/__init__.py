"""Report: what a run leaves for people and for other programs.

``page`` renders any page of the program from ``templates``. ``run_page`` is the page of a run, with ``text`` for words
and tables, ``figures`` of the flight, ``tracker_figures``, and ``replay`` for what moves; ``run_files`` are the arrays
of the run with units in their names, ``columns`` the same as tables, ``frames`` for pandas. ``run_figures`` has the
figures of a run by short names, ``notebook`` what a console and a notebook show of a result.
"""
