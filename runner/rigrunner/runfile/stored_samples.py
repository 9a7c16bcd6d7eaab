"""Samples of a finished recording that stay in their file, and are read by slices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.runfile.hdf5 import open_file

if TYPE_CHECKING:
    from pathlib import Path

    import h5py

    from rigrunner.api.data import Array

IN_MEMORY = 1 << 26
"""Bytes of a run's samples up to which they are read at once."""


@dataclass(frozen=True, eq=False)
class StoredSamples:
    """One channel of a recording in a file, shape (samples,). Every slice opens the file again.

    Raises DataError where the file can no longer be read, or is another one than it was.
    """

    path: Path
    place: str
    samples: int
    state: tuple[int, int]
    """The file's size and the time of its last change, in ns: a sealed file keeps both."""

    @classmethod
    def of(cls, column: h5py.Dataset, path: Path) -> StoredSamples:
        """Return the samples of a dataset in an open file."""
        return cls(path, str(column.name), len(column), _state(path))

    def __len__(self) -> int:
        """Return how many there are."""
        return self.samples

    def __getitem__(self, which: slice, /) -> Array:
        """Return those from one index to another, in memory."""
        with open_file(self.path) as file:
            if _state(self.path) != self.state:
                raise DataError(f"{self.path} was changed while it was read")
            return np.asarray(file[self.place][which], np.float64)

    def __array__(self, dtype: object = None, *, copy: bool | None = None) -> Array:
        """Return all of them, in memory."""
        return self[:]


def _state(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_size, found.st_mtime_ns
