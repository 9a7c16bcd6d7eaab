"""Whether a file can be walked through at all, found out in a process of its own.

On a file whose structure is damaged the HDF5 library can crash, and take the process with it. The
structure of a file of the layout that we write has checksums, which the library looks at first; one
of an older layout has none, and is tried elsewhere before it is opened here.
"""

from __future__ import annotations

import subprocess
import sys
from functools import lru_cache
from pathlib import Path

import h5py

from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.runfile.hdf5 import UNREADABLE, is_checksummed, objects, open_file

_LEAST_S = 60.0
_BYTES_PER_S = 1e6
"""Far slower than any machine that a run file was verified on."""
_CHILD = "import sys; from rigrunner.runfile.probe import walk; walk(sys.argv[1])"


def refuse_crashing(path: Path) -> None:
    """Raise DataError for a file on which the HDF5 library crashes, or does not come to an end."""
    limit_s = _LEAST_S + path.stat().st_size / _BYTES_PER_S
    try:
        done = subprocess.run(  # noqa: S603  (this interpreter, on a text of ours)
            [
                sys.executable,
                "-P",
                "-c",
                _CHILD,
                str(path),
            ],  # -P: no module of the folder we are in
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=limit_s,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise DataError(
            f"{path} cannot be read: its structure is damaged, the HDF5 library does not end",
            hint="take it from a copy",
        ) from error
    if done.returncode:
        raise DataError(
            f"{path} cannot be read: its structure is damaged, the HDF5 library crashes on it"
            f" (exit code {done.returncode})",
            hint="take it from a copy",
        )


def refuse_unprotected_crashing(path: Path) -> None:
    """Do so for a file whose structure has no checksums; what is no HDF5 file is let through."""
    if path.is_file() and is_checksummed(path) is False:
        known = path.stat()
        _refuse_once(path, known.st_mtime_ns, known.st_size)


@lru_cache(maxsize=64)
def _refuse_once(path: Path, _mtime_ns: int, _size: int) -> None:
    """Try a file that did not change once for all times that it is opened."""
    refuse_crashing(path)


def walk(path: str) -> None:
    """Read all of a file; what is said of it is for another process to find again."""
    try:
        with open_file(Path(path)) as file:
            dict(file.attrs)
            for _, item in objects(file):
                try:
                    dict(item.attrs)
                    _read_all(item)
                except UNREADABLE:
                    continue
    except RigrunnerError:
        return


def _read_all(item: h5py.Group | h5py.Dataset) -> None:
    if isinstance(item, h5py.Group):
        return
    for part in item.iter_chunks() if item.chunks else [()]:
        item[part]
