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

from rigrunner.api.errors import DataError
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
_DAMAGED = (OSError, RuntimeError, MemoryError)
_NO_RUN = (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError)
UNREADABLE = (*_DAMAGED, *_NO_RUN)
"""What h5py and those who read its objects raise on files that are damaged, or something else."""
_STORED_SIZE = re.compile(r"stored_eof = ([0-9]+)")
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_FIRST_CHECKSUMMED = 3
"""The version of the superblock that came with HDF5 1.10."""
_MOST_PER_BYTE = 1100
"""gzip, which run files use for samples, packs at most 1032 bytes into one."""
_MOST_TEXT_PER_BYTE, _ALWAYS_TEXT = 64, 1 << 28
"""Texts are read into memory whole: so many bytes for each of the file, and so many more. Of a run
of many steps they take a twentieth of their size."""
_PIECE = 1 << 18
"""Bytes of a text or of a column of texts that are packed together; shorter ones are not packed."""
_DEEPEST = 20
"""Groups in groups; a run has less than ten."""


@contextmanager
def new_file(path: Path, *, read_only: bool = False) -> Iterator[h5py.File]:
    """Give an HDF5 file that appears under its name whole and durable, or not at all.

    A Ctrl-C meanwhile is taken once the file is there. Its structure has checksums, which the
    layouts before that of HDF5 1.10 have not: damage is then found, and crashes no reader.
    """
    with uninterrupted(), writing(path):
        with PatientFile(temporary(path)) as patient:
            try:
                with h5py.File(patient, "w", libver=("v110", "v110")) as file:
                    yield file
            except Exception:
                if patient.error is None:
                    raise  # else what was read back was not what had been written
            if patient.error is not None:
                raise patient.error
        publish(path, read_only=read_only)


def is_checksummed(path: Path) -> bool | None:
    """Return whether the structure of an HDF5 file has checksums; None where it is no such file.

    By the version of the superblock (HDF5 file format specification, II.A).
    """
    try:
        with path.open("rb") as file:
            begin = file.read(len(_SIGNATURE) + 1)
        if not begin.startswith(_SIGNATURE):
            # Such as one that begins with a user block, which we do not write.
            return False if h5py.is_hdf5(path) else None
    except OSError:
        return None
    return begin[-1] >= _FIRST_CHECKSUMMED


@contextmanager
def open_file(path: Path) -> Iterator[h5py.File]:
    """Give an HDF5 file for reading; raise DataError where it, or its content, cannot be read."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except FileNotFoundError as error:
        raise there_is_none(path) from error
    # These two are OSErrors, as damage is: they have to come before it.
    except BlockingIOError as error:
        raise DataError(
            f"{path} is locked: another program has it open", hint="close it there"
        ) from error
    except PermissionError as error:
        raise must_not_be_read(path) from error
    except _DAMAGED as error:
        raise DataError(
            f"{path} cannot be read: it is not an HDF5 file, or truncated or damaged",
            hint=f"{_damage(path, error)}; restore it from a copy or a backup; 'rigrunner recover"
            " --salvage' saves the intact recordings of a run",
        ) from error
    except _NO_RUN as error:
        raise DataError(f"{path} is not a run of Rigrunner, or damaged", hint=str(error)) from error


def there_is_none(path: Path) -> DataError:
    """Return the error of a file that is not there."""
    return DataError(f"there is no file {path}")


def must_not_be_read(path: Path) -> DataError:
    """Return the error of a file or folder that its rights keep from being read."""
    return DataError(
        f"no permission to read {path}", hint="ask its owner for permission to read it"
    )


def _damage(path: Path, error: Exception) -> str:
    """Return what is wrong with a file that is no HDF5 file, or not whole, in a person's words."""
    if not path.is_file():
        return "it is a folder"
    size, stored = path.stat().st_size, _STORED_SIZE.search(str(error))
    if not size:
        return "it is empty"
    if stored is not None:
        return f"it ends after {size:,} of its {int(stored[1]):,} bytes"
    if "signature not found" in str(error):
        return "it does not start with the signature of HDF5"
    return str(error)


def members(group: h5py.Group) -> list[str]:
    """Return the names of a group's members, sorted; raise DataError for one that is a link.

    A run file has no soft or external links: they could lead out of the file, or round in it.
    """
    names = sorted(group)
    for name in names:
        if group.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
            raise DataError(f"{group.file.filename}: {group.name}/{name} is a link, not data")
    return names


def objects(group: h5py.Group) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    """Yield all groups and datasets below a group with their paths from it, sorted by name.

    Raises DataError where the structure is damaged, or is none that a run file has: a group in two
    places, values that are kept in another file, or that say they are more than the file can hold.
    """
    size, claimed, texts = group.file.id.get_filesize(), 0.0, 0
    for path, item in _below(group, "", {_address(group)}):
        if isinstance(item, h5py.Dataset):
            is_packed = item.chunks is not None
            if is_packed and item.dtype.kind in "uS":
                texts += item.nbytes
            else:
                is_samples = is_packed and item.dtype.kind == "f"
                claimed += item.nbytes / (_MOST_PER_BYTE if is_samples else 1)
            refuse_odd(item)
            if claimed > size or texts > _MOST_TEXT_PER_BYTE * size + _ALWAYS_TEXT:
                raise DataError(
                    f"{group.file.filename}: {item.name} says it is larger than the file"
                )
        yield path, item


def _below(
    group: h5py.Group, prefix: str, seen: set[int]
) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    if prefix.count("/") > _DEEPEST:
        raise DataError(f"{group.file.filename}: its groups are nested deeper than those of a run")
    for name in members(group):
        path, item = f"{prefix}{name}", _member(group, name)
        yield path, item
        if isinstance(item, h5py.Group):
            if _address(item) in seen:
                raise DataError(f"{group.file.filename}: {item.name} is given twice")
            seen.add(_address(item))
            yield from _below(item, f"{path}/", seen)


def refuse_odd(item: h5py.Dataset) -> None:
    """Raise DataError for values that are not in the file: they could be changed beside it."""
    if item.is_virtual or item.external:
        raise DataError(f"{item.file.filename}: {item.name} is kept in another file")
    if item.dtype.hasobject:
        raise DataError(
            f"{item.file.filename}: {item.name} is of a type that no run file has: {item.dtype}"
        )


def _member(group: h5py.Group, name: str) -> h5py.Group | h5py.Dataset:
    try:
        item = group[name]
    except UNREADABLE as error:
        raise DataError(
            f"{group.file.filename}: {group.name}/{name} cannot be read: it is damaged",
            hint=str(error),
        ) from error
    if not isinstance(item, (h5py.Group, h5py.Dataset)):
        raise DataError(f"{group.file.filename}: {group.name}/{name} is neither group nor dataset")
    return item


def _address(group: h5py.Group) -> int:
    # Its place in the file, which is the same by any of its names.
    return int(h5py.h5o.get_info(group.id).addr)


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
    group.create_dataset(name, data=data, **_packed(len(data), data.itemsize))


def write_long(group: h5py.Group, name: str, text: LongText) -> None:
    """Write a long text as `write_verbatim` does, one part after the other."""
    size, first = sum(map(len, text)), 0
    column = group.create_dataset(name, (size,), np.uint8, **_packed(size, 1))
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
        column = group.create_dataset(name, (count,), kind, **_packed(count, kind.itemsize))
        rows, cells = _rows(kind.itemsize), iter(self._cells)
        for first in range(0, count, rows):
            column[first : first + rows] = np.array([*islice(cells, rows)], kind)


def pieces_of(column: h5py.Dataset) -> Iterator[NDArray[Any]]:
    """Yield the rows of a column, or the bytes of a text, in order, as they are packed."""
    rows = _rows(column.dtype.itemsize)
    return (column[first : first + rows] for first in range(0, len(column), rows))


def _rows(itemsize: int) -> int:
    return max(_PIECE // itemsize, 1)


def _packed(rows: int, itemsize: int) -> dict[str, Any]:
    """Return how to store a text, or a column of texts: as it is, or packed where it is large."""
    if rows * itemsize < _PIECE:
        return {}
    return {"chunks": (min(_rows(itemsize), rows),), "compression": "gzip", "compression_opts": 1,
            "fletcher32": True}  # fmt: skip
