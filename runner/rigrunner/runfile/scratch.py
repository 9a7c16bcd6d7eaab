"""A cache on disk for decompressed samples.

An analysis reads a channel six or seven times, and to decompress it takes ten times as long as to
read it. The file is in the system's folder for temporary files (`TMPDIR`), has no name, and is
removed with its process, however that ends. Missing samples are decompressed again.
"""

from __future__ import annotations

import shutil
import tempfile
import weakref
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from io import FileIO

    from rigrunner.api.data import Array

PIECE = 1 << 14
"""Samples that are stored together: a chunk of a run file."""
_BYTES = 8 * PIECE
SHARE = 0.5
"""The used share of the disk space that was free at first."""


class Scratch:
    """Decompressed samples of one run, in pieces of one file, which is opened when it is needed."""

    def __init__(self) -> None:
        """Start empty."""
        self._pieces = 0
        self._sums: dict[int, int] = {}
        """The checksum of each stored piece: samples that a disk damaged are not used."""
        self._file: FileIO | None = None
        self._reserve_bytes = 0.0
        self._lock = Lock()

    def __reduce__(self) -> tuple[type[Scratch], tuple[()]]:
        """Start empty in another process."""
        return Scratch, ()

    def room(self, samples: int) -> int:
        """Return the first of as many pieces as a channel needs."""
        first = self._pieces
        self._pieces += -(-samples // PIECE)
        return first

    def keep(self, piece: int, samples: Array) -> None:
        """Store samples from the beginning of a piece on, if there is room for them."""
        samples = np.pad(samples, (0, -len(samples) % PIECE)) if len(samples) % PIECE else samples
        try:
            with self._lock:
                file = self._open()
                if _free_bytes() - samples.nbytes < self._reserve_bytes:
                    return
                file.seek(piece * _BYTES)
                written = file.write(samples.data)
        except OSError:
            return  # a disk that is full, or none: it is not needed
        if written == samples.nbytes:
            self._sums.update(enumerate(_sums(samples), piece))

    def read(self, piece: int, count: int) -> Array | None:
        """Return that many pieces, shape (count * PIECE,); None if one is missing."""
        sums = [self._sums.get(index) for index in range(piece, piece + count)]
        if None in sums:
            return None
        samples = np.empty(count * PIECE)
        try:
            with self._lock:
                file = self._open()
                file.seek(piece * _BYTES)
                size = file.readinto(samples.data.cast("B"))
        except OSError:
            return None
        return samples if size == samples.nbytes and _sums(samples) == sums else None

    def _open(self) -> FileIO:
        if self._file is None:
            self._reserve_bytes = SHARE * _free_bytes()
            self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115  (closed with self)
            weakref.finalize(self, self._file.close)
        return self._file


def _free_bytes() -> int:
    return shutil.disk_usage(tempfile.gettempdir()).free


def _sums(samples: Array) -> list[int]:
    """Return the sum of each piece as whole numbers, modulo 2^64."""
    sums: list[int] = samples.view(np.uint64).reshape(-1, PIECE).sum(axis=1).tolist()
    return sums
