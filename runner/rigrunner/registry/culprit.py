"""Finds the plugin that raised an unexpected exception, from its traceback."""

from __future__ import annotations

from traceback import walk_stack, walk_tb
from typing import TYPE_CHECKING

from rigrunner.api.hooks import PROJECT
from rigrunner.registry.installed import installed

if TYPE_CHECKING:
    from collections.abc import Iterable
    from types import FrameType

DROP_IN = "rigrunner_drop_in_"
"""Prefix of the module name of a file in the folder of a lab."""


def culprit(error: BaseException) -> str:
    """Return the third-party plugin that raised an exception, with file and line; '' for none.

    It is the innermost frame of a plugin; code that it calls may be at fault too.
    """
    plugin = _innermost(walk_tb(error.__traceback__))
    if not plugin and error.__cause__ is not None:
        return culprit(error.__cause__)
    return plugin


def whereabouts(frame: FrameType) -> str:
    """Return the third-party plugin of a frame, or of its callers; '' for none."""
    return _innermost(reversed(list(walk_stack(frame))))


def _innermost(frames: Iterable[tuple[FrameType, int]]) -> str:
    """Return the last of these frames that is of a plugin; they begin with the outermost."""
    providers = {
        provider.place.partition(":")[0].partition(".")[0]: provider
        for provider in installed()
        if provider.distribution != PROJECT
    }
    innermost = ""
    for frame, line in frames:
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        place = f"{frame.f_code.co_filename}:{line}"
        if package.startswith(DROP_IN):
            innermost = place
        elif package in providers:
            innermost = f"{providers[package].name} {providers[package].version}, {place}"
    return innermost
