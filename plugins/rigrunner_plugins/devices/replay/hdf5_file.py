"""Samples out of an HDF5 file, as they stand there: no unit is converted here."""

from __future__ import annotations

from typing import TYPE_CHECKING

import h5py
import numpy as np

from rigrunner.api.errors import DataError, Location

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api.data import Array


def read_hdf5(path: Path, columns: Mapping[str, int | str], group: str) -> dict[str, Array]:
    """Return each channel's samples, shape (n,), from its dataset's path within the group.

    Raises DataError naming file and dataset.
    """
    try:
        with h5py.File(path, "r") as file:
            return {
                channel: _dataset(file, f"{group.rstrip('/')}/{column}", path)
                for channel, column in columns.items()
            }
    except OSError as error:
        raise DataError("is not a readable HDF5 file", location=Location(str(path))) from error


def _dataset(file: h5py.File, name: str, path: Path) -> Array:
    try:
        found = file[name]
    except KeyError:
        raise _bad(path, name, "is not there") from None
    if not isinstance(found, h5py.Dataset) or found.ndim != 1 or found.dtype.kind not in "iuf":
        raise _bad(path, name, "is not a list of numbers")
    if found.file.filename != file.filename or found.is_virtual or found.external:
        raise _bad(path, name, "is kept in another file")
    samples = np.asarray(found[...], dtype=np.float64)
    finite = np.isfinite(samples)
    if not finite.all():
        raise _bad(path, name, f"is not finite at sample {int(np.argmin(finite))}")
    return samples


def _bad(path: Path, name: str, problem: str) -> DataError:
    return DataError(f"the dataset '{name}' {problem}", location=Location(str(path)))
