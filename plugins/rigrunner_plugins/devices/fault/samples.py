"""What goes wrong with the samples of one channel; each fault is drawn for a whole recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from rigrunner.api import Array
    from rigrunner_plugins.devices.fault.settings import FaultSettings, Kind

DRIFT_S = 600.0
"""In which a drift reaches its extent; from then on it stays."""


class Spoil(Protocol):
    """Spoils the samples of a recording, block after block."""

    def __call__(self, first: int, values: Array) -> Array:
        """Return samples (n,) spoilt, of which the first has this index in the recording."""
        ...


@dataclass(frozen=True)
class Stream:
    """The recording that a fault is drawn for."""

    samples: int
    rate_hz: float
    since_connected_s: float


def spoil_for(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil | None:
    """Return what a fault does to the samples; None where it is another fault."""
    make = _SPOILS.get(fault.kind)
    return None if make is None else make(fault, stream, rng)


def _nan(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:
    indices = _places(fault, stream, rng)

    def spoil(first: int, values: Array) -> Array:
        part = _within(indices, first, values)
        return _replaced(values, indices[part] - first, np.nan)

    return spoil


def _spikes(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:
    places = _places(fault, stream, rng)
    sizes = rng.uniform(0.5, 1.0, len(places)) * rng.choice([-1.0, 1.0], len(places))

    def spoil(first: int, values: Array) -> Array:
        part = _within(places, first, values)
        index = places[part] - first
        return _replaced(values, index, values[index] + fault.extent_si * sizes[part])

    return spoil


def _stuck(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:
    length = max(2, round(fault.part * stream.samples))
    begin = int(rng.integers(max(stream.samples - length, 0) + 1))
    stuck_at: list[float] = []

    def spoil(first: int, values: Array) -> Array:
        index = np.arange(max(begin - first, 0), max(min(begin + length - first, len(values)), 0))
        if not len(index):
            return values
        # The first one counts: what stood there when it got stuck, also in the blocks that follow.
        stuck_at.append(float(values[index[0]]))
        return _replaced(values, index, stuck_at[0])

    return spoil


def _clipped(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:  # noqa: ARG001  (nothing is drawn)
    level = abs(fault.extent_si)
    return lambda _, values: np.clip(values, -level, level)


def _drift(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:  # noqa: ARG001  (nothing is drawn)
    def spoil(first: int, values: Array) -> Array:
        since_s = stream.since_connected_s + (first + np.arange(len(values))) / stream.rate_hz
        return values + fault.extent_si * np.minimum(since_s / DRIFT_S, 1.0)

    return spoil


def _noise(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:  # noqa: ARG001  (of any length)
    return lambda _, values: values + abs(fault.extent_si) * rng.standard_normal(len(values))


def _sensitivity(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> Spoil:  # noqa: ARG001  (nothing is drawn)
    return lambda _, values: values * (1 + fault.extent_si)


_SPOILS: dict[Kind, Callable[[FaultSettings, Stream, np.random.Generator], Spoil]] = {
    "nan": _nan,
    "spikes": _spikes,
    "stuck": _stuck,
    "clipped": _clipped,
    "drift": _drift,
    "noise": _noise,
    "sensitivity": _sensitivity,
}
KINDS = frozenset(_SPOILS)
"""Those of faults that affect samples of one channel."""


def _places(fault: FaultSettings, stream: Stream, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return which samples it affects, sorted: at least one, where there is any."""
    count = min(max(1, round(fault.part * stream.samples)), stream.samples)
    return np.sort(rng.choice(stream.samples, count, replace=False))


def _within(places: NDArray[np.intp], first: int, values: Array) -> slice:
    begin, end = np.searchsorted(places, [first, first + len(values)])
    return slice(int(begin), int(end))


def _replaced(values: Array, index: NDArray[np.intp], by: float | Array) -> Array:
    spoilt = np.array(values, dtype=np.float64)
    spoilt[index] = by
    return spoilt
