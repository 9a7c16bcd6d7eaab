"""Rigrunner: a plugin-based runner of laboratory test procedures.

For notebooks and scripts: `rigrunner.open_run`, `rigrunner.analyse`, and `rigrunner.archive.query`.
"""

from importlib import import_module
from typing import Any

try:
    from rigrunner._version import __version__  # a wheel has it: .ci/built_version.py
except ModuleNotFoundError:
    __version__ = "0.1.0+source"  # sources may be at any commit, so no tag tells theirs

_LAZY = {
    "analyse": "rigrunner.notebook",
    "open_run": "rigrunner.notebook",
    "archive": "rigrunner.archive",
}
"""What a notebook asks for, and where it is: imported then, since the command line starts here."""


def __getattr__(name: str) -> Any:
    """Return what notebooks ask for (PEP 562); `__init__.pyi` tells editors of it."""
    if name not in _LAZY:
        raise AttributeError(f"module 'rigrunner' has no attribute '{name}'")
    module = import_module(_LAZY[name])
    return module if _LAZY[name] == f"rigrunner.{name}" else getattr(module, name)


def __dir__() -> list[str]:
    """Return all names, for those who complete them."""
    return sorted({*globals(), *_LAZY})
