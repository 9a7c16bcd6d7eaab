"""Whether a file can be walked through at all, found out in a process of its own.

On a file whose structure is damaged the HDF5 library can crash, and take the process with it.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.runfile.reading import file_differences, read

_LEAST_S = 60.0
_BYTES_PER_S = 1e6
"""Far slower than any machine that a run file was verified on."""
_CHILD = "import sys; from rigrunner.runfile.probe import walk; walk(sys.argv[1])"


def refuse_crashing(path: Path) -> None:
    """Raise DataError for a file on which the HDF5 library crashes, or does not come to an end."""
    limit_s = _LEAST_S + path.stat().st_size / _BYTES_PER_S
    try:
        done = subprocess.run(  # noqa: S603  (this interpreter, on a text of ours)
            [sys.executable, "-c", _CHILD, str(path)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=limit_s,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise DataError(
            f"{path} cannot be read: its structure is damaged, the HDF5 library does not end"
        ) from error
    if done.returncode:
        raise DataError(
            f"{path} cannot be read: its structure is damaged, the HDF5 library crashes on it"
            f" (exit code {done.returncode})"
        )


def walk(path: str) -> None:
    """Read all of a file; what is said of it is for another process to find again."""
    for reader in (file_differences, read):
        try:
            reader(Path(path))
        except RigrunnerError:
            continue
