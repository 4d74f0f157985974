"""One BLAS thread for each process: matrices here are small, and threads that wait for each other double the time."""

from __future__ import annotations

import os

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def one_thread() -> None:
    """Before numpy is imported: one thread, unless the user wants otherwise."""
    for name in THREADS:
        os.environ.setdefault(name, "1")
