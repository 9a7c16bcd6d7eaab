"""Read a run, sealed or not."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import members, no_permission, objects, open_file
from rigrunner.runfile.codec import check_format
from rigrunner.runfile.entry import (
    FORMAT_ATTRIBUTE,
    read_entry,
    read_entry_info,
    read_entry_truth,
)
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.loose import read_journal, read_loose, read_loose_info
from rigrunner.runfile.manifest import differences
from rigrunner.runfile.probe import refuse_unprotected_crashing

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    import h5py

    from rigrunner.runfile.manifest import Difference
    from rigrunner.runfile.model import RunInfo, StoredRun

    Truth = Mapping[str, Mapping[str, float]]

ENTRY = "entry"
FIRST_WITH_MANIFEST = 2
"""The first version of the layout with a manifest."""


def read(path: Path) -> StoredRun:
    """Read a run folder, sealed or not, or a `run.h5`; samples are bit by bit the recorded ones.

    Raises DataError if it is not a run, is truncated or damaged, is of a newer version, or if its
    content differs from its digests.
    """
    sealed = sealed_file_of(path)
    if sealed is None:
        return read_loose(RunFolder(path))
    with _entry_of(sealed, walk=False) as entry:
        return _read(entry, sealed)


def read_with_truth(path: Path) -> tuple[StoredRun, Truth]:
    """Read a run with the truth of its simulator, like `read` and `read_truth`, in one pass."""
    sealed = sealed_file_of(path)
    if sealed is None:
        return read_loose(RunFolder(path)), read_truth(path)
    with _entry_of(sealed, walk=False) as entry:
        return _read(entry, sealed), read_entry_truth(entry)


def read_without_samples(folder: Path) -> StoredRun:
    """Read the events of an active run; it has no recordings. Raises DataError."""
    return read_loose(RunFolder(folder), samples=False)


def read_info(path: Path) -> RunInfo:
    """Read the description of a run without its samples; raises as `read`."""
    sealed = sealed_file_of(path)
    if sealed is None:
        return read_loose_info(RunFolder(path))
    with _entry_of(sealed) as entry:
        return read_entry_info(entry, sealed)


def read_truth(path: Path) -> Truth:
    """Read the truth of a simulator, by recording: for verification, never for an analysis."""
    sealed = sealed_file_of(path)
    if sealed is None:
        return read_journal(RunFolder(path)).truth
    with _entry_of(sealed) as entry:
        return read_entry_truth(entry)


def file_differences(path: Path) -> list[Difference] | None:
    """Return the differences of a `run.h5` from its manifest; None without a manifest.

    Raises DataError if the file cannot be opened or walked through.
    """
    with _entry_of(path, walk=False) as entry:
        return _differences(entry, samples=True)


def sealed_file_of(path: Path) -> Path | None:
    """Return the sealed file of a run; None for a run that is not sealed; raise DataError."""
    try:
        return _sealed_file_of(path)
    except PermissionError as error:
        raise no_permission(path) from error


def _sealed_file_of(path: Path) -> Path | None:
    if path.is_file():
        return path
    if not path.exists():
        raise DataError(f"there is no run {path}")
    files = RunFolder(path)
    # First: a kill may have left a journal beside it.
    if files.sealed_file.exists():
        return files.sealed_file
    if not files.events.exists():
        raise DataError(
            f"{path} is not a run",
            hint="a run folder has a run.h5 or, until it is sealed, a journal",
        )
    return None


@contextmanager
def _entry_of(path: Path, *, walk: bool = True) -> Iterator[h5py.Group]:
    refuse_unprotected_crashing(path)
    with open_file(path) as file:
        if FORMAT_ATTRIBUTE not in file.attrs:
            raise DataError(f"{path} is an HDF5 file, but not a run of Rigrunner")
        check_format(int(file.attrs[FORMAT_ATTRIBUTE]), str(path))
        members(file)  # refuses links: the entry could be in another file
        for _ in objects(file) if walk else ():
            pass  # refuses what no run file has
        yield file[ENTRY]


def check_file(path: Path) -> None:
    """Raise DataError if anything in a `run.h5` differs from its manifest, also samples."""
    _refuse(file_differences(path), path)


def _read(entry: h5py.Group, path: Path) -> StoredRun:
    """Read a run, and refuse one of which anything differs from its manifest."""
    # First: it walks through the file, and refuses what no run file has.
    differences_found = _differences(entry, samples=False)
    run = read_entry(entry, path)
    _refuse(differences_found, path)
    return run


def _refuse(differences_found: list[Difference] | None, path: Path) -> None:
    if differences_found:
        raise DataError(
            f"{path}: {differences_found[0]}",
            hint=f"'rigrunner verify {path}' lists all that differs, and"
            " 'rigrunner recover --salvage' saves the intact recordings",
        )


def _differences(entry: h5py.Group, *, samples: bool) -> list[Difference] | None:
    """Walk through a file, as `_entry_of` does; return its differences, None without manifest."""
    if int(entry.file.attrs[FORMAT_ATTRIBUTE]) >= FIRST_WITH_MANIFEST:
        return list(differences(entry, samples=samples))
    for _ in objects(entry.file):
        pass
    return None
