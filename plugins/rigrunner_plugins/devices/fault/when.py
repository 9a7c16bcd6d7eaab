"""Which faults affect a call: by set-point, by number, or by chance."""

from __future__ import annotations

import math
import zlib
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner_plugins.devices.fault.settings import Call, FaultSettings


class Occasions:
    """Counts the calls that a fault may affect, since the device was connected.

    What is left to chance follows from the seed, the call, the set-points and how often the call
    was made there: the order in which set-points come does not matter.
    """

    def __init__(self, faults: Sequence[FaultSettings], seed: int) -> None:
        self._faults = tuple(faults)
        self._seed = seed
        self._calls: Counter[int] = Counter()
        self._there: Counter[tuple[int, str]] = Counter()

    def begin(self) -> None:
        """Count anew."""
        self._calls.clear()
        self._there.clear()

    def due(
        self, call: Call, set_points: Mapping[str, float], drive: str = ""
    ) -> Iterator[tuple[FaultSettings, np.random.Generator]]:
        """Yield the faults that affect this call, each with its source of random numbers."""
        place = f"{call} {drive} " + " ".join(f"{k}={v:.6g}" for k, v in set_points.items())
        for index, fault in enumerate(self._faults):
            if fault.call != call or fault.drive not in ("", drive) or not _at(fault, set_points):
                continue
            self._calls[index] += 1
            self._there[index, place] += 1
            words = zlib.crc32(place.encode())
            rng = np.random.default_rng([self._seed, index, words, self._there[index, place]])
            chance = rng.uniform()
            chosen = not fault.calls or self._calls[index] in fault.calls
            if chosen and chance < fault.probability:
                yield fault, rng


def _at(fault: FaultSettings, set_points: Mapping[str, float]) -> bool:
    return all(
        math.isclose(set_points[drive], wanted.si, rel_tol=1e-6)
        for drive, wanted in fault.at.items()
    )
