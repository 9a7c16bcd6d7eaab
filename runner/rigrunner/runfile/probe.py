"""Find out in a separate process whether a file can be read at all.

On a file with a damaged structure the HDF5 library can crash, with the process. The structure of a
file in our layout has checksums, which the library checks first. A file of an older layout has
none, and is tried in another process before it is opened here.
"""

from __future__ import annotations

import subprocess
import sys
from functools import lru_cache
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.hdf5_reading import is_checksummed

if TYPE_CHECKING:
    from pathlib import Path

_LEAST_S = 60.0
"""The child first has to start Python and load HDF5, on a busy machine too."""
_BYTES_PER_S = 1e6
"""Far slower than any machine on which a run file was verified."""
_CHILD = """\
import sys
from pathlib import Path
from rigrunner.hdf5_reading import walk
walk(Path(sys.argv[1]))
"""


def refuse_crashing(path: Path) -> None:
    """Raise DataError for a file on which the HDF5 library crashes or hangs."""
    limit_s = _LEAST_S + path.stat().st_size / _BYTES_PER_S
    try:
        # -P: no module of the present folder is imported.
        result = subprocess.run(  # noqa: S603  (this interpreter, on a text of ours)
            [sys.executable, "-P", "-c", _CHILD, str(path)],
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
    if result.returncode:
        raise DataError(
            f"{path} cannot be read: its structure is damaged, the HDF5 library crashes on it"
            f" (exit code {result.returncode})",
            hint="take it from a copy",
        )


def refuse_unprotected_crashing(path: Path) -> None:
    """Raise DataError for such a file without checksums; a file that is not HDF5 is accepted."""
    if path.is_file() and is_checksummed(path) is False:
        stat = path.stat()
        _refuse_once(path, stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=64)
def _refuse_once(path: Path, _mtime_ns: int, _size: int) -> None:
    """Try an unchanged file once only, however often it is opened."""
    refuse_crashing(path)
