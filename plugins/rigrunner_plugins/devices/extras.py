"""Optional packages: the error where one is missing."""

from __future__ import annotations

from rigrunner.api import MissingPackageError


def missing_package(package: str, extra: str) -> MissingPackageError:
    """Return the error for a package that is not installed, saying which extra brings it."""
    return MissingPackageError(
        f"the package '{package}' is not installed", hint=f"pip install 'rigrunner[{extra}]'"
    )
