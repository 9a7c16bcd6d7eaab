"""Samples of a finished recording that stay in their file, and are read by slices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import missing_file, open_file
from rigrunner.runfile.scratch import PIECE

if TYPE_CHECKING:
    from pathlib import Path

    import h5py

    from rigrunner.api.data import Array
    from rigrunner.runfile.scratch import Scratch

IN_MEMORY = 1 << 26
"""Size of a run's samples, in bytes, up to which they are read at once."""


@dataclass(frozen=True, eq=False)
class StoredSamples:
    """One channel of a recording in a file, shape (samples,), decompressed on access.

    Decompressed samples are cached on disk, as far as there is room. Every slice checks the file
    again: raises DataError if the file can no longer be read, or was replaced.
    """

    path: Path
    place: str
    samples: int
    state: tuple[int, int]
    """The file's size and the time of its last change, in ns. A sealed file keeps both."""
    limits: tuple[float, float] | None
    """The smallest and the largest value; not-a-number if a sample is, None without samples."""
    scratch: Scratch
    piece: int
    """Its first piece in the scratch file."""

    @classmethod
    def of(
        cls, column: h5py.Dataset, path: Path, limits: tuple[float, float] | None, scratch: Scratch
    ) -> StoredSamples:
        """Return the samples of a dataset in an open file."""
        piece = scratch.room(len(column))
        return cls(path, str(column.name), len(column), _state(path), limits, scratch, piece)

    def __len__(self) -> int:
        """Return the number of samples."""
        return self.samples

    def __getitem__(self, which: slice, /) -> Array:
        """Return the samples of a slice, in memory."""
        begin, end, step = which.indices(self.samples)
        # Only whole pieces in a row are cached.
        if step != 1 or end <= begin:
            return self._unpack(which)
        first, last = begin // PIECE, -(-end // PIECE)
        return self._pieces(first, last)[begin - first * PIECE : end - first * PIECE]

    def __array__(self, dtype: object = None, *, copy: bool | None = None) -> Array:
        """Return all samples, in memory."""
        return self._unpack(slice(None))

    def _pieces(self, first: int, last: int) -> Array:
        cached = self.scratch.read(self.piece + first, last - first)
        # What is cached is of the file as it was.
        if cached is not None:
            self._refuse_changed()
            return cached
        unpacked = self._unpack(slice(first * PIECE, last * PIECE))
        self.scratch.keep(self.piece + first, unpacked)
        return unpacked

    def _unpack(self, which: slice) -> Array:
        with open_file(self.path) as file:
            # Once it is open: what replaces the file from now on is not what is read.
            self._refuse_changed()
            return np.asarray(file[self.place][which], np.float64)

    def _refuse_changed(self) -> None:
        try:
            state = _state(self.path)
        except FileNotFoundError as error:
            raise missing_file(self.path) from error
        if state != self.state:
            raise DataError(f"{self.path} was changed while it was read")


def _state(path: Path) -> tuple[int, int]:
    stat = path.stat()
    return stat.st_size, stat.st_mtime_ns
