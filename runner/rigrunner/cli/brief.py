"""Tune the garbage collector for commands, which keep most objects until their end."""

from __future__ import annotations

import gc
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


SELDOM = 200_000
"""Number of new objects after which a command of seconds collects: some 50 MB at most."""


@contextmanager
def brief_command() -> Iterator[None]:
    """Switch off the garbage collector in a command of less than a second.

    It would run again and again while classes and models are created, for a sixth of the time of
    `check`, and find nothing. The objects are frozen, or the end of the command would search them
    all.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.freeze()
            gc.enable()


@contextmanager
def short_command() -> Iterator[None]:
    """Collect garbage rarely in a command of seconds, and not at its end.

    The collections are a tenth of the time of `report`. They are not switched off: the analysis of
    a long run, or one with a validation, does leave garbage.
    """
    before = gc.get_threshold()
    gc.set_threshold(SELDOM, *before[1:])
    try:
        yield
    finally:
        gc.freeze()
        gc.set_threshold(*before)
