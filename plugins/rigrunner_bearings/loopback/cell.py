"""A load cell that talks without being asked: ten lines a second on a serial line (a pty)."""

from __future__ import annotations

import os
import pty
import threading
import tty
from contextlib import suppress
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from rigrunner_plugins.devices.plant import Plant

LINES_PER_S = 10.0
NOISE_N = 0.3


def line(load_n: float) -> bytes:
    """Return what the cell says of a load: 'ST,+01000.2 N' and a carriage return with line feed."""
    return f"ST,{load_n:+08.1f} N\r\n".encode("ascii")


class LoadCell:
    """The cell with its thread; a context manager."""

    def __init__(self, plant: Plant, seed: int) -> None:
        self._plant = plant
        self._rng = np.random.default_rng([seed, 2])
        self._over = threading.Event()
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self.port = os.ttyname(self._theirs)
        self._thread = threading.Thread(target=self._talk, name="load cell", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        os.close(self._ours)
        os.close(self._theirs)

    def _talk(self) -> None:
        while not self._over.wait(1 / LINES_PER_S):
            load_n = self._plant.load_n + self._rng.normal(0, NOISE_N)
            with suppress(BlockingIOError):  # nobody reads: what is old is lost, as on a real line
                os.write(self._ours, line(load_n))
