"""An array that lies in a file and is read where it is used: what a large ensemble leaves would fill the memory."""

from __future__ import annotations

import math
import os
import tempfile
import weakref
from typing import Any

import numpy as np

from sim.errors import OutputError


class FiledArray:
    """An array (..., runs) in a file without a name, to which runs are added; it ends with this object.

    It is an array to numpy's functions (``np.asarray`` reads it) and has the members below; an index reads it as well,
    so that whoever needs it more than once keeps what he read. Raises ``OutputError`` where it cannot be written.
    """

    def __init__(self, first: np.ndarray) -> None:
        self.dtype = first.dtype
        self.shape: tuple[int, ...] = (*first.shape[:-1], 0)
        self._runs: list[int] = []  # of each part; the file holds one part after the other
        try:
            with tempfile.TemporaryFile(prefix="shortfinal.") as file:
                self._file = os.dup(file.fileno())
        except OSError as error:
            raise OutputError(_refused(error)) from None
        weakref.finalize(self, os.close, self._file)
        self.add(first)

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return int(self.shape[0])

    def add(self, part: Any) -> None:
        """Further runs, (..., more of them)."""
        part = np.ascontiguousarray(part, dtype=self.dtype)
        if part.shape[:-1] != self.shape[:-1]:
            raise ValueError(f"a part of the shape {part.shape} does not continue one of {self.shape}")
        try:
            with open(self._file, "ab", closefd=False) as file:
                part.tofile(file)
        except OSError as error:
            raise OutputError(_refused(error)) from None
        self._runs.append(part.shape[-1])
        self.shape = (*self.shape[:-1], self.shape[-1] + part.shape[-1])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        """All of it, read anew."""
        whole, first = np.empty(self.shape, self.dtype), 0
        with open(self._file, "rb", closefd=False) as file:
            file.seek(0)
            for runs in self._runs:
                shape = (*self.shape[:-1], runs)
                part = np.fromfile(file, self.dtype, math.prod(shape))
                whole[..., first : first + runs] = part.reshape(shape)
                first += runs
        return whole if dtype is None else whole.astype(dtype, copy=False)

    def __getitem__(self, index: Any) -> Any:
        return np.array(np.asarray(self)[index])

    def __reduce__(self) -> Any:
        """A copy, and what goes to another process, is a plain array."""
        return np.array, (np.asarray(self),)

    def astype(self, dtype: Any) -> np.ndarray:
        """A copy of another type."""
        return np.asarray(self).astype(dtype)


def _refused(error: OSError) -> str:
    why = error.strerror or error
    return f"{tempfile.gettempdir()}: so many draws need room in this folder: {why}; TMPDIR names another"
