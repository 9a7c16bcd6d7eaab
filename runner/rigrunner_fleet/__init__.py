"""Many runs: archive, trends, re-analysis, golden runs, and runs for notebooks.

For notebooks and scripts: `rigrunner_fleet.open_run`, `rigrunner_fleet.analyse`, and
`rigrunner_fleet.archive.query`.
"""

from importlib import import_module
from typing import Any

_LAZY = {
    "analyse": "rigrunner_fleet.notebook",
    "open_run": "rigrunner_fleet.notebook",
    "archive": "rigrunner_fleet.archive",
}
"""The names for notebooks, and their modules. They are imported on access, since the commands start
here."""


def __getattr__(name: str) -> Any:
    """Return a name for notebooks (PEP 562); `__init__.pyi` lists them for editors."""
    if name not in _LAZY:
        raise AttributeError(f"module 'rigrunner_fleet' has no attribute '{name}'")
    module = import_module(_LAZY[name])
    return module if _LAZY[name] == f"rigrunner_fleet.{name}" else getattr(module, name)


def __dir__() -> list[str]:
    """Return all names, for completion."""
    return sorted({*globals(), *_LAZY})
