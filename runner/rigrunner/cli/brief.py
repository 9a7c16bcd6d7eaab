"""Commands that are over in an instant."""

from __future__ import annotations

import gc
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def brief_command() -> Iterator[None]:
    """Leave out the search for garbage in a command that keeps nearly all it makes until its end.

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
