"""The command ``shortfinal``.

``commands`` are its sub-commands. Text for a terminal: ``run_summary``, ``explain``, ``listing``, ``contract`` and
``doctor``, in the tables of ``text_table``, with ``progress`` while one waits. ``export`` writes records for other
programs; ``fleet`` flies all aircraft of JSBSim and keeps the table that ``list --aircraft`` shows.
"""
