"""Processes: ``executors`` for many flights here, ``cluster`` for a Dask cluster behind the same three calls.

``isolation`` is a child for models that may abort or hang, ``helper_process`` a second process that takes a part of a
run; ``blas`` gives each of them one thread.
"""
