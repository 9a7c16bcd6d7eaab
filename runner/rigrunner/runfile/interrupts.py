"""Keeps Ctrl-C out of what must not be interrupted halfway."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let a Ctrl-C wait until this is over; then it is as if it came just then.

    HDF5 calls back into Python to write. It goes on after an exception there, with the bytes at
    another place or not at all: the file would be published, and wrong.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are taken by the main thread alone
        return
    came: list[FrameType | None] = []
    former = signal.signal(signal.SIGINT, lambda _, frame: came.append(frame))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, former)
        if callable(former):
            for frame in came:
                former(signal.SIGINT, frame)
