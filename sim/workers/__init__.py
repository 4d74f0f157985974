"""Processes: ``executors`` for many flights here, ``cluster`` for a Dask cluster behind the same three calls.

``helper_process`` is another process that does one call after another: ``isolation`` has it load models that may abort
or hang, ``sharing`` has it take a part of a run. ``partners`` ends the waiting for those that fall silent,
``last_words`` keeps what those say that die. ``blas`` gives each process one thread.
"""
