"""As if the bearings were not installed: the core's tests know no swing.

    PYTHONPATH=tests python -m pytest -p without_bearings tests/unit/engine tests/unit/procedure

Nobody can import the package, and its entry points are not there. `.ci/run` says what runs so.
"""

from __future__ import annotations

import sys
from importlib import metadata

BEARINGS = "rigrunner_bearings"


class _Missing:
    """Finds no module of the package, as the machine would without it."""

    @staticmethod
    def find_spec(name, path=None, target=None):  # noqa: ARG004  (Python's signature)
        if name.partition(".")[0] == BEARINGS:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


assert BEARINGS not in sys.modules, "it was imported before this plugin of pytest"
_entry_points = metadata.entry_points


def entry_points(**asked):
    """Return all but those of the bearings, whoever found them: Dask brings a finder of its own."""
    found = _entry_points(**asked)
    return type(found)(each for each in found if each.name != BEARINGS)


metadata.entry_points = entry_points
sys.meta_path.insert(0, _Missing)
