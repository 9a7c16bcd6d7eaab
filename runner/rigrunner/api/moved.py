"""Names of 0.1.0 that have moved; found here for one release, with a warning."""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import Any

_MOVED = {
    "CompensationRecord": "rigrunner_bearings.api",
    "Influence": "rigrunner_bearings.api",
}
"""Present place of each name."""


def moved(module: str, name: str) -> Any:
    """Return a moved name of a module; raise AttributeError for any other name."""
    place = _MOVED.get(name)
    if place is None:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    text = f"import {name} from {place}: its old name goes with the next release"
    warnings.warn(text, DeprecationWarning, stacklevel=3)
    return getattr(import_module(place), name)
