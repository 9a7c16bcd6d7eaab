"""Packages that are needed only for data frames or Parquet."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from rigrunner.api.errors import MissingPackageError


def imported(name: str) -> Any:
    """Import a package of the extra 'export'; raise MissingPackageError."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"this needs {error.name}", hint="pip install 'rigrunner[export]'"
        ) from error
