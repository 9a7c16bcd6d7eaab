"""The conformance kit: the requirements on every plugin, as checks that a test can call.

For a package's own tests there is a pytest plugin, `rigrunner_testing.pytest_plugin`; on the
command line it is `rigrunner check-plugin NAME`.
"""

from importlib import import_module
from typing import Any

_LAZY = {
    "AnyCheck": "rigrunner_testing.check",
    "Check": "rigrunner_testing.check",
    "Finding": "rigrunner_testing.check",
    "Nonconformity": "rigrunner_testing.check",
    "NotApplicable": "rigrunner_testing.check",
    "State": "rigrunner_testing.check",
    "Subject": "rigrunner_testing.subjects",
    "checks": "rigrunner_testing.kinds",
    "conform": "rigrunner_testing.examination",
    "examine": "rigrunner_testing.examination",
    "examine_one": "rigrunner_testing.examination",
    "replayed": "rigrunner_testing.replays",
    "subject": "rigrunner_testing.kinds",
}
"""The names for tests, and their modules. They are imported on access, since the command's help
line is here."""

__all__ = [
    "AnyCheck",
    "Check",
    "Finding",
    "Nonconformity",
    "NotApplicable",
    "State",
    "Subject",
    "checks",
    "conform",
    "examine",
    "examine_one",
    "replayed",
    "subject",
]


def __getattr__(name: str) -> Any:
    """Return a name of the kit (PEP 562); `__init__.pyi` lists them for editors."""
    if name not in _LAZY:
        raise AttributeError(f"module 'rigrunner_testing' has no attribute '{name}'")
    return getattr(import_module(_LAZY[name]), name)


def __dir__() -> list[str]:
    """Return all names, for completion."""
    return sorted({*globals(), *_LAZY})
