"""The kinds of steps as records, as in the plugin of a lab."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from rigrunner import steps
from rigrunner.api.hooks import hookimpl

if TYPE_CHECKING:
    from rigrunner.api.hooks import StepRecord


@hookimpl
def rigrunner_steps() -> list[StepRecord]:
    """Return the kind of each module of this package."""
    modules = iter_modules(steps.__path__, f"{steps.__name__}.")
    return [import_module(module.name).STEP for module in modules if module.name != __name__]
