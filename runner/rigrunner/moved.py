"""Names that have moved to another package; their old places work for one release, with a warning.

A package names a table by an entry point of the group `rigrunner.moved`. The table gives the new
place of each old one, of modules and of names in modules; of a property, a function of the object:

    MOVED = {
        "rigrunner.signal.peaks": "mypackage.peaks",
        "rigrunner.api.Peak": "mypackage.api:Peak",
        "rigrunner.api.results.Result.peak": "mypackage.api:peak_of",
    }
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from types import ModuleType

GROUP = "rigrunner.moved"


@cache
def places() -> Mapping[str, str]:
    """Return the new place of each old one, as the installed packages state it."""
    from importlib.metadata import entry_points  # noqa: PLC0415  (only old names need it)

    tables = (entry_point.load() for entry_point in entry_points(group=GROUP))
    return {old: new for table in tables for old, new in table.items()}


def moved(module: str, name: str) -> Any:
    """Return a name that has moved from a module or class; raise AttributeError for any other."""
    place = None if name.startswith("__") else places().get(f"{module}.{name}")
    if place is None or ":" not in place:
        raise AttributeError(f"{module!r} has no attribute {name!r}")
    new_module, _, new_name = place.partition(":")
    text = f"import {new_name} from {new_module}: the old name will be removed in the next release"
    warnings.warn(text, DeprecationWarning, stacklevel=3)
    return getattr(import_module(new_module), new_name)


class MovedModules:
    """Finds modules of this package that have moved; the last finder that Python consults."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how to load a module from its new place; None if it has none."""
        del path, target
        place = places().get(name) if name.startswith("rigrunner.") else None
        return None if place is None else ModuleSpec(name, _Moved(place))


class _Moved(Loader):
    """Loads a module that has moved: the module at the new place has both names."""

    def __init__(self, place: str) -> None:
        self._place = place

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave it to Python."""

    def exec_module(self, module: ModuleType) -> None:
        """Put the module of the new place in the place of the old one."""
        text = f"import {self._place} instead: the old name will be removed in the next release"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        sys.modules[module.__name__] = import_module(self._place)
