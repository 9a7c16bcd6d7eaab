"""The faults that a study puts into recordings, from harmless to gross, and how each is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.random import Generator


@dataclass(frozen=True, kw_only=True)
class DataFault:
    """One way to spoil a recording."""

    name: str
    extent: str
    """The range from which it is drawn, in words."""
    draw: Callable[[Generator], Mapping[str, Any]]
    """Returns the fault as settings of the plugin `fault`, without its place."""
    unseen: str = ""
    """Why no data can show it; empty if data can."""
    both_runs: bool = False
    """Whether it affects both runs alike, at every set-point."""


def _logarithmic(rng: Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _signed(rng: Generator, low: float, high: float) -> float:
    return _logarithmic(rng, low, high) * float(rng.choice([-1.0, 1.0]))


def _torque(number: float) -> str:
    return f"{number:.6g} N·m"


def _share(rng: Generator, low: float, high: float) -> str:
    return f"{100 * _logarithmic(rng, low, high):.6g} %"


def _seconds(rng: Generator, low: float, high: float) -> str:
    return f"{_logarithmic(rng, low, high):.6g} s"


FAULTS = (
    DataFault(
        name="not a number",
        extent="1 sample to 1 %",
        draw=lambda rng: {"kind": "nan", "share": _share(rng, 1e-5, 1e-2)},
    ),
    DataFault(
        name="torque stuck",
        extent="0.1 to 40 % of a recording",
        draw=lambda rng: {"kind": "stuck", "share": _share(rng, 1e-3, 0.4)},
    ),
    DataFault(
        name="angle stuck",
        extent="0.1 to 40 % of a recording",
        draw=lambda rng: {"kind": "stuck", "channel": "angle", "share": _share(rng, 1e-3, 0.4)},
    ),
    DataFault(
        name="torque clipped",
        extent="beyond 0.5 to 6 N·m",
        draw=lambda rng: {"kind": "clipped", "extent": _torque(_logarithmic(rng, 0.5, 6))},
    ),
    DataFault(
        name="angle clipped",
        extent="beyond 1 to 2.5°",
        draw=lambda rng: {
            "kind": "clipped", "channel": "angle", "extent": f"{rng.uniform(1, 2.5):.6g} deg",
        },
    ),
    DataFault(
        name="blocks dropped", extent="one", draw=lambda _: {"kind": "dropped blocks"}
    ),
    DataFault(name="block twice", extent="one", draw=lambda _: {"kind": "repeated block"}),
    DataFault(name="wrong order", extent="two blocks", draw=lambda _: {"kind": "wrong order"}),
    DataFault(
        name="gap in time",
        extent="0.2 to 5 s, the times tell",
        draw=lambda rng: {"kind": "gap", "extent": _seconds(rng, 0.2, 5)},
    ),
    DataFault(
        name="hidden gap in time",
        extent="0.1 ms to 0.3 s, nothing tells",
        draw=lambda rng: {"kind": "hidden gap", "extent": _seconds(rng, 1e-4, 0.3)},
    ),
    DataFault(
        name="time back",
        extent="by 10 ms to 5 s",
        draw=lambda rng: {"kind": "time back", "extent": _seconds(rng, 0.01, 5)},
    ),
    DataFault(
        name="torque spikes",
        extent="0.05 to 10 N·m in 0.01 to 5 % of the samples",
        draw=lambda rng: {
            "kind": "spikes",
            "extent": _torque(_logarithmic(rng, 0.05, 10)),
            "share": _share(rng, 1e-4, 0.05),
        },
    ),
    DataFault(
        name="angle spikes",
        extent="0.05 to 5° in 0.01 to 5 % of the samples",
        draw=lambda rng: {
            "kind": "spikes",
            "channel": "angle",
            "extent": f"{_logarithmic(rng, 0.05, 5):.6g} deg",
            "share": _share(rng, 1e-4, 0.05),
        },
    ),
    DataFault(
        name="torque drifts",
        extent="by 0.01 to 2 N·m in 10 min, either way",
        draw=lambda rng: {"kind": "drift", "extent": _torque(_signed(rng, 0.01, 2))},
    ),
    DataFault(
        name="wrong frequency",
        extent="0.1 to 5 %, either way",
        draw=lambda rng: {
            "kind": "wrong frequency", "extent": f"{100 * _signed(rng, 1e-3, 0.05):.6g} %",
        },
    ),
    DataFault(
        name="torque noise",
        extent="0.02 to 2 N·m per sample",
        draw=lambda rng: {"kind": "noise", "extent": _torque(_logarithmic(rng, 0.02, 2))},
    ),
    DataFault(
        name="angle noise",
        extent="0.002 to 0.5° per sample",
        draw=lambda rng: {
            "kind": "noise", "channel": "angle",
            "extent": f"{_logarithmic(rng, 0.002, 0.5):.6g} deg",
        },
    ),
)  # fmt: skip
"""Those that data can show, if they matter."""

UNSEEN = (
    DataFault(
        name="torque sensitivity",
        extent="2 to 5 % away, either way, in both runs",
        draw=lambda rng: {
            "kind": "sensitivity", "extent": f"{100 * _signed(rng, 0.02, 0.05):.6g} %",
        },
        unseen="a torque that is too large by a factor is a larger torque:"
        " only a calibration tells",
        both_runs=True,
    ),
)  # fmt: skip
