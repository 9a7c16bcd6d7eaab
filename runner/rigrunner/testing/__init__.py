"""Deprecated: the conformance kit is `rigrunner_testing`; this name goes with the next release."""

import warnings
from importlib import import_module
from typing import Any

warnings.warn("import rigrunner_testing in place of it", DeprecationWarning, stacklevel=2)


def __getattr__(name: str) -> Any:
    """Return a name of the kit; AttributeError if it has none of that name."""
    return getattr(import_module("rigrunner_testing"), name)
