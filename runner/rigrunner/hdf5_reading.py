"""Opening and reading HDF5 files of any origin.

It imports h5py and the errors alone: a process that tries a file starts with it.
"""

from __future__ import annotations

import re
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import h5py

from rigrunner.api.errors import DataError, RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

CACHE = 1 << 20
"""Bytes of a dataset that HDF5 keeps unpacked. Datasets are read and written in order, so that the
8 MB of HDF5 2.0 for each would save nothing."""
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
"""Allowed bytes of text, which is read into memory as a whole: for each byte of the file, and in
addition. In a run of many steps texts are packed to a twentieth of their size."""
_DEEPEST = 20
"""Groups in groups; a run has less than ten."""


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
        with h5py.File(path, "r", rdcc_nbytes=CACHE) as file:
            yield file
    except FileNotFoundError as error:
        raise missing_file(path) from error
    # These two are OSErrors, as damage is: they have to come before it.
    except BlockingIOError as error:
        raise DataError(
            f"{path} is locked: another program has it open", hint="close it there"
        ) from error
    except PermissionError as error:
        raise no_permission(path) from error
    except _DAMAGED as error:
        raise DataError(
            f"{path} cannot be read: it is not an HDF5 file, or truncated or damaged",
            hint=f"{_damage(path, error)}; restore it from a copy or a backup; 'rigrunner recover"
            " --salvage' saves the intact recordings of a run",
        ) from error
    except _NO_RUN as error:
        raise DataError(f"{path} is not a run of Rigrunner, or damaged", hint=str(error)) from error


def missing_file(path: Path) -> DataError:
    """Return the error of a missing file."""
    return DataError(f"there is no file {path}")


def no_permission(path: Path) -> DataError:
    """Return the error of a file or folder that this user must not read."""
    return DataError(
        f"no permission to read {path}", hint="ask its owner for permission to read it"
    )


def _damage(path: Path, error: Exception) -> str:
    """Return what is wrong with a file that is no HDF5 file, or incomplete, in plain words."""
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
    kinds: dict[str, int] = {}

    def note(name: bytes, link: Any) -> None:
        kinds[name.decode()] = link.type

    group.id.links.iterate(note, info=True)
    for name in sorted(kinds):
        if kinds[name] != h5py.h5l.TYPE_HARD:
            raise DataError(f"{group.file.filename}: {group.name}/{name} is a link, not data")
    return sorted(kinds)


def objects(group: h5py.Group) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    """Yield all groups and datasets below a group with their paths from it, sorted by name.

    Raises DataError where the structure is damaged, or is none that a run file has: a group in two
    places, values that are stored in another file, or larger by their own statement than the file.
    """
    size, claimed, texts = group.file.id.get_filesize(), 0.0, 0
    is_read_only = group.file.mode == "r"
    for path, item in _below(group, "", {_address(group)}, is_read_only=is_read_only):
        if isinstance(item, h5py.Dataset):
            is_packed = item.chunks is not None
            if is_packed and item.dtype.kind in "uS":
                texts += item.nbytes
            else:
                is_samples = is_packed and item.dtype.kind == "f"
                claimed += item.nbytes / (_MOST_PER_BYTE if is_samples else 1)
            refuse_external(item)
            if claimed > size or texts > _MOST_TEXT_PER_BYTE * size + _ALWAYS_TEXT:
                raise DataError(
                    f"{group.file.filename}: {item.name} says it is larger than the file"
                )
        yield path, item


def _below(
    group: h5py.Group, prefix: str, seen: set[int], *, is_read_only: bool
) -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    if prefix.count("/") > _DEEPEST:
        raise DataError(f"{group.file.filename}: its groups are nested deeper than those of a run")
    for name in members(group):
        path, item = f"{prefix}{name}", _member(group, name, is_read_only=is_read_only)
        yield path, item
        if isinstance(item, h5py.Group):
            if _address(item) in seen:
                raise DataError(f"{group.file.filename}: {item.name} is given twice")
            seen.add(_address(item))
            yield from _below(item, f"{path}/", seen, is_read_only=is_read_only)


def refuse_external(item: h5py.Dataset) -> None:
    """Raise DataError for values that are not in the file: they could be changed beside it."""
    if item.is_virtual or item.external:
        raise DataError(f"{item.file.filename}: {item.name} is kept in another file")
    if item.dtype.hasobject:
        raise DataError(
            f"{item.file.filename}: {item.name} is of a type that no run file has: {item.dtype}"
        )


def _member(group: h5py.Group, name: str, *, is_read_only: bool) -> h5py.Group | h5py.Dataset:
    # As group[name] does, which looks up the mode of the file each time: most of its duration.
    try:
        object_id = h5py.h5o.open(group.id, name.encode())
    except UNREADABLE as error:
        raise DataError(
            f"{group.file.filename}: {group.name}/{name} cannot be read: it is damaged",
            hint=str(error),
        ) from error
    if isinstance(object_id, h5py.h5g.GroupID):
        return h5py.Group(object_id)
    if isinstance(object_id, h5py.h5d.DatasetID):
        return h5py.Dataset(object_id, readonly=is_read_only)
    raise DataError(f"{group.file.filename}: {group.name}/{name} is neither group nor dataset")


def _address(group: h5py.Group) -> int:
    # Its place in the file, which is the same by any of its names.
    return int(h5py.h5o.get_info(group.id).addr)


def walk(path: Path) -> None:
    """Read all of a file; its errors are reported by the process that opens it."""
    try:
        with open_file(path) as file:
            dict(file.attrs)
            for _, item in objects(file):
                try:
                    dict(item.attrs)
                    if isinstance(item, h5py.Dataset):
                        for part in item.iter_chunks() if item.chunks else [()]:
                            item[part]
                except UNREADABLE:
                    continue
    except RigrunnerError:
        return
