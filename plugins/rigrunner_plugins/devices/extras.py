"""Optional packages: the error where one is missing, and theirs in short."""

from __future__ import annotations

import errno
import os

from rigrunner.api import MissingPackageError


def missing_package(package: str, extra: str) -> MissingPackageError:
    """Return the error for a package that is not installed, saying which extra brings it."""
    return MissingPackageError(
        f"the package '{package}' is not installed", hint=f"pip install 'rigrunner[{extra}]'"
    )


def reason_of(error: Exception) -> str:
    """Return why a serial port cannot be opened; pyserial repeats the name of a missing one."""
    number = getattr(error, "errno", None)
    return os.strerror(number) if number in {errno.ENOENT, errno.EACCES} else str(error)
