"""Delay Ctrl-C during operations that must not be interrupted."""

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
    """Delay a Ctrl-C until the end of the block, where it is raised.

    HDF5 calls back into Python to write. After an exception there it continues, with the bytes at
    another place or missing: a wrong file would be published.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals are taken by the main thread alone
        return
    frames: list[FrameType | None] = []
    previous = signal.signal(signal.SIGINT, lambda _, frame: frames.append(frame))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
        # SIG_IGN and SIG_DFL are not.
        if callable(previous):
            for frame in frames:
                previous(signal.SIGINT, frame)
