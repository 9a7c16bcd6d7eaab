"""How often a command searches for garbage: most of what it makes it keeps until its end."""

from __future__ import annotations

import gc
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


SELDOM = 200_000
"""Objects more than before, at which a command of seconds searches: some 50 MB at most."""


@contextmanager
def brief_command() -> Iterator[None]:
    """Leave out the search for garbage in a command that is over in an instant.

    Classes and models make the collector search again and again, for a sixth of the time of
    `check`, and find nothing. They are frozen, or the end of the command would search them all.
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
    """Search for garbage seldom in a command of seconds, and not at its end.

    The searches are a tenth of the time of `report`. They are not left out: the analysis of a long
    run, or one with a validation, does make some.
    """
    before = gc.get_threshold()
    gc.set_threshold(SELDOM, *before[1:])
    try:
        yield
    finally:
        gc.freeze()
        gc.set_threshold(*before)
