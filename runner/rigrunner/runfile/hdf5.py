"""HDF5 in the shape that viewers and other languages read: the few habits of this project.

Short texts are UTF-8 attributes, long ones uint8 datasets; string columns are fixed ASCII, and what
is large is packed by gzip, with a checksum; files open in readers that have HDF5 1.10.
"""

from __future__ import annotations

import re
from contextlib import contextmanager
from itertools import islice
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from rigrunner.hdf5_reading import CACHE
from rigrunner.runfile.compressed import Compressed, LongText
from rigrunner.runfile.durable import publish, temporary, writing
from rigrunner.runfile.interrupts import uninterrupted
from rigrunner.runfile.patient_file import PatientFile

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

_LONGEST_ATTRIBUTE = 32_000
"""In bytes; HDF5 itself ends at 64 kB, and several attributes share an object's header."""
_PIECE = 1 << 18
"""Bytes of a text or of a column of texts that are packed together; shorter ones are not packed."""


@contextmanager
def new_file(path: Path, *, read_only: bool = False) -> Iterator[h5py.File]:
    """Give an HDF5 file that appears under its name whole and durable, or not at all.

    A Ctrl-C meanwhile is taken once the file is there. Its structure has checksums, which the
    layouts before that of HDF5 1.10 have not: damage is then found, and crashes no reader.
    """
    with uninterrupted(), writing(path):
        with PatientFile(temporary(path)) as patient:
            try:
                with h5py.File(patient, "w", libver=("v110", "v110"), rdcc_nbytes=CACHE) as file:
                    yield file
            except Exception:
                if patient.error is None:
                    raise  # else what was read back was not what had been written
            if patient.error is not None:
                raise patient.error
        publish(path, read_only=read_only)


def new_group(parent: h5py.Group, name: str, nx_class: str) -> h5py.Group:
    """Make a group of a NeXus class; its members keep the order in which they are made."""
    group = parent.create_group(name, track_order=True)
    group.attrs["NX_class"] = nx_class
    return group


def free_name(parent: h5py.Group, name: str) -> str:
    """Return a name for a member of a group that NeXus allows, such as 'tester_torque'.

    It has letters, digits and '_', and begins with no digit: '_001_1Hz'. What it stands for is kept
    in the member's attribute 'name'.
    """
    safe = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "unnamed"
    safe = f"_{safe}" if safe[0].isdigit() else safe
    candidate, number = safe, 2
    while candidate in parent:
        candidate, number = f"{safe}_{number}", number + 1
    return candidate


def write_text(group: h5py.Group, name: str, text: str) -> None:
    """Write a text as an attribute, or as a uint8 dataset where it is too long for one."""
    # A NUL would end the text of an attribute.
    if len(text.encode(errors="surrogateescape")) > _LONGEST_ATTRIBUTE or "\0" in text:
        write_verbatim(group, name, text)
    else:
        group.attrs[name] = str(text)


def write_verbatim(group: h5py.Group, name: str, text: str) -> None:
    """Write a text, byte by byte, as a uint8 dataset."""
    data = np.frombuffer(text.encode(errors="surrogateescape"), np.uint8)
    group.create_dataset(name, data=data, **_storage(len(data), data.itemsize))


def write_long(group: h5py.Group, name: str, text: LongText) -> None:
    """Write a long text as `write_verbatim` does, one part after the other."""
    size, first = sum(map(len, text)), 0
    column = group.create_dataset(name, (size,), np.uint8, **_storage(size, 1))
    for part in text:
        column[first : first + len(part)] = np.frombuffer(part, np.uint8)
        first += len(part)


def read_long(group: h5py.Group, name: str) -> LongText:
    """Read what `write_long` or `write_verbatim` wrote."""
    return LongText(part.tobytes() for part in pieces_of(group[name]))


def read_text(group: h5py.Group, name: str) -> str:
    """Read what `write_text` or `write_verbatim` wrote."""
    if name in group.attrs:
        return str(group.attrs[name])
    return str(group[name][()], "utf-8", "surrogateescape")


def write_texts(parent: h5py.Group, name: str, texts: Mapping[str, str]) -> None:
    """Write named texts as a group of their own."""
    group = new_group(parent, name, "NXcollection")
    for key, text in texts.items():
        entry = new_group(group, free_name(group, key), "NXcollection")
        write_text(entry, "name", key)
        write_text(entry, "text", text)


def read_texts(group: h5py.Group) -> dict[str, str]:
    """Read what `write_texts` wrote."""
    return {read_text(entry, "name"): read_text(entry, "text") for entry in group.values()}


def write_values(
    parent: h5py.Group, name: str, values: Mapping[str, float], units: Mapping[str, str]
) -> None:
    """Write named numbers, each a float64 scalar with its unit, as a group of their own."""
    group = new_group(parent, name, "NXcollection")
    for key, value in values.items():
        dataset = group.create_dataset(free_name(group, key), data=np.float64(value))
        dataset.attrs["name"] = str(key)  # h5py takes no other kind of text, as a Member is
        if key in units:
            dataset.attrs["units"] = units[key]


def read_values(group: h5py.Group) -> tuple[dict[str, float], dict[str, str]]:
    """Read what `write_values` wrote: values and units by name."""
    items = {str(item.attrs["name"]): item for item in group.values()}
    values = {name: float(item[()]) for name, item in items.items()}
    units = {
        name: str(item.attrs["units"]) for name, item in items.items() if "units" in item.attrs
    }
    return values, units


def write_ascii(group: h5py.Group, name: str, texts: Iterable[str]) -> None:
    """Write a column of texts as fixed-length ASCII; what is not ASCII becomes an escape."""
    column = AsciiColumn()
    column.add(texts)
    column.write(group, name)


class AsciiColumn:
    """A column of texts, as `write_ascii` writes it, of which the rows come in pieces."""

    def __init__(self) -> None:
        self._cells = Compressed()
        self._longest = 1

    def add(self, texts: Iterable[str]) -> None:
        """Add the texts of the next rows."""
        cells = [text.encode("ascii", "backslashreplace") for text in texts]
        self._cells.add(cells)
        self._longest = max(self._longest, *map(len, cells), 0)

    def write(self, group: h5py.Group, name: str) -> None:
        """Write all rows; only now is it known how long they are."""
        kind, count = np.dtype(f"S{self._longest}"), len(self._cells)
        column = group.create_dataset(name, (count,), kind, **_storage(count, kind.itemsize))
        rows, cells = _rows(kind.itemsize), iter(self._cells)
        for first in range(0, count, rows):
            column[first : first + rows] = np.array([*islice(cells, rows)], kind)


def pieces_of(column: h5py.Dataset) -> Iterator[NDArray[Any]]:
    """Yield the rows of a column, or the bytes of a text, in order, as they are packed."""
    rows = _rows(column.dtype.itemsize)
    return (column[first : first + rows] for first in range(0, len(column), rows))


def _rows(itemsize: int) -> int:
    return max(_PIECE // itemsize, 1)


def _storage(rows: int, itemsize: int) -> dict[str, Any]:
    """Return how to store a text, or a column of texts: as it is, or packed where it is large."""
    if rows * itemsize < _PIECE:
        return {}
    return {"chunks": (min(_rows(itemsize), rows),), "compression": "gzip", "compression_opts": 1,
            "fletcher32": True}  # fmt: skip
