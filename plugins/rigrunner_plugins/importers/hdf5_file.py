"""Samples out of an HDF5 file, as they stand there: no unit is converted here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import h5py
import numpy as np

from rigrunner.api import Column, DataError, Location, NotInFileError
from rigrunner_plugins.importers.finding import near, numbers

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.api import NoSettings

_PACKED = ("scale_factor", "add_offset")
"""Attributes of numbers that are not the values (CF Conventions, 8.1)."""
_MISSING = ("_FillValue", "missing_value")
"""Attributes with a number that stands for a missing value (CF Conventions, 2.5.1)."""


@dataclass(frozen=True)
class Hdf5Importer:
    """Reads HDF5 files, in which a recording is a group of datasets."""

    settings: NoSettings

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return the wanted columns; see `rigrunner.api.importing.Importer`."""
        return read_hdf5(path, columns, group)


def read_hdf5(path: Path, columns: Mapping[str, int | str], group: str) -> dict[str, Column]:
    """Return each wanted column, which is a dataset by its path within the group.

    Its unit is its attribute `units` or `unit`. Raises DataError naming file and dataset.
    """
    try:
        with h5py.File(path, "r") as file:
            return {
                wanted: _column(file, wanted, f"{group.rstrip('/')}/{column}", path)
                for wanted, column in columns.items()
            }
    except (OSError, RuntimeError, ValueError) as error:
        raise DataError("is not a readable HDF5 file", location=Location(str(path))) from error


def _column(file: h5py.File, wanted: str, name: str, path: Path) -> Column:
    try:
        node = file[name]
    except KeyError:
        parent, _, leaf = name.rpartition("/")
        siblings = file.get(parent or "/")
        hint = f"there is no group '{parent}'"
        if isinstance(siblings, h5py.Group):
            hint = near(leaf, names_in(siblings), f"in '{parent or '/'}'")
        raise NotInFileError(
            f"the dataset '{name}' of '{wanted}' is not there",
            wanted=wanted,
            location=Location(str(path)),
            hint=hint,
        ) from None
    if not isinstance(node, h5py.Dataset) or node.ndim != 1 or node.dtype.kind not in "iuf":
        raise _bad(path, name, "is not a list of numbers")
    if node.file.filename != file.filename or node.is_virtual or node.external:
        raise _bad(path, name, "is kept in another file")
    if has_damaged_chunk(node):
        raise _bad(path, name, "is damaged")
    packed = [key for key in _PACKED if key in node.attrs]
    if packed:
        raise _bad(path, name, f"is packed, which is not read: it has the attribute {packed[0]}")
    samples = node[...]
    for key in _MISSING:
        if key in node.attrs and np.isin(samples, node.attrs[key]).any():
            raise _bad(path, name, f"has missing values: {node.attrs[key]}, its {key}")
    return Column(numbers(samples, f"the dataset '{name}'", path), _unit(node))


def has_damaged_chunk(dataset: h5py.Dataset) -> bool:
    """Return whether a filtered chunk is empty or outside of the file: HDF5 may crash on it."""
    if dataset.chunks is None or not dataset.id.get_create_plist().get_nfilters():
        return False
    file_size = dataset.file.id.get_filesize()

    def is_outside(chunk: h5py.h5d.StoreInfo) -> bool | None:
        """Return True to end the iteration, None to continue."""
        return None if 0 < chunk.size <= file_size - chunk.byte_offset else True

    return dataset.id.chunk_iter(is_outside) is not None


def names_in(group: h5py.Group) -> list[str]:
    """Return the names in a group; h5py gives one that is no UTF-8 as bytes."""
    return [name if isinstance(name, str) else name.decode("utf-8", "replace") for name in group]


def _unit(dataset: h5py.Dataset) -> str:
    """Return the unit that the file states; '' where it states none, or in no text."""
    for name in ("units", "unit", "Units", "Unit"):
        value = dataset.attrs.get(name, "")
        if isinstance(value, np.ndarray) and value.size == 1:  # as MATLAB writes a text
            value = value.item()
        text = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        if isinstance(text, str) and text:
            return text
    return ""


def _bad(path: Path, name: str, problem: str) -> DataError:
    return DataError(f"the dataset '{name}' {problem}", location=Location(str(path)))
