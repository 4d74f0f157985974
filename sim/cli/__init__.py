"""The command ``shortfinal``.

``commands`` are its sub-commands, ``endings`` how they end. Text for a terminal: ``run_summary``, ``explain``,
``listing``, ``contract`` and ``doctor``; ``terminal`` has tables, a progress bar and streams. `exporting` writes
records for other programs; ``fleet`` flies all aircraft of JSBSim and keeps the table that ``list --aircraft`` shows.
"""
