"""Names that stood here in 0.1.0 and have moved: they are found for one release, with a warning."""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import Any

_MOVED = {
    "CompensationRecord": "rigrunner_bearings.api",
    "Influence": "rigrunner_bearings.api",
}
"""Where each is now."""


def moved(module: str, name: str) -> Any:
    """Return a name that has moved from a module; raise AttributeError for any other name."""
    place = _MOVED.get(name)
    if place is None:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    text = f"import {name} from {place}: its old name goes with the next release"
    warnings.warn(text, DeprecationWarning, stacklevel=3)
    return getattr(import_module(place), name)
