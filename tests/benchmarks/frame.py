"""The parts of a benchmark: figures with spread, ratios of pairs, targets, counted work."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import tracemalloc
from dataclasses import dataclass, field
from statistics import quantiles
from typing import TYPE_CHECKING

from benchmarks.peer import Peers

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


@dataclass(frozen=True)
class Scale:
    """The size of a benchmark, and the environment of other projects' programs."""

    short: bool = False
    peers: Peers = field(default_factory=Peers)

    def of(self, full: int, short: int) -> int:
        return short if self.short else full


@dataclass(frozen=True)
class Spread:
    """The median of repetitions, and their quartiles."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float]) -> Spread:
        ordered = sorted(values)
        if len(ordered) == 1:
            return cls(ordered[0], ordered[0], ordered[0])
        low, median, high = quantiles(ordered, n=4, method="inclusive")
        return cls(median, low, high)

    def per(self, count: float) -> Spread:
        """Return it divided by a count: seconds per turn of a loop, or another unit."""
        return Spread(self.median / count, self.low / count, self.high / count)

    def rate(self, count: float) -> Spread:
        """Return the rate from the time of `count` items."""
        return Spread(count / self.median, count / self.high, count / self.low)


@dataclass(frozen=True)
class Target:
    """The target of a figure: for its ratio to the floor, or for its value if it has a unit."""

    bound: float
    unit: str = ""
    at_least: bool = False

    def met(self, value: float) -> bool:
        return value >= self.bound if self.at_least else value <= self.bound


def at_most(bound: float, unit: str = "") -> Target:
    return Target(bound, unit)


def at_least(bound: float, unit: str = "") -> Target:
    return Target(bound, unit, at_least=True)


@dataclass(frozen=True)
class Figure:
    """One row of a table; `value` is None if it could not be measured, and `note` says why."""

    what: str
    value: Spread | None
    unit: str
    role: str = "ours"  # or "floor", or "peer"
    ratio: Spread | None = None
    target: Target | None = None
    note: str = ""  # for ours: what limits it

    def met(self) -> bool | None:
        """Return whether the median meets its target; None without a target or a value."""
        spread = self.value if self.target and self.target.unit else self.ratio
        return None if self.target is None or spread is None else self.target.met(spread.median)


@dataclass(frozen=True)
class Work:
    """Counted work of the short form, which does not depend on the machine, and its maximum."""

    what: str
    counted: float
    at_most: float


@dataclass(frozen=True)
class Pair:
    """Seconds of ours and of the floor, and their ratios in each turn."""

    ours: Spread
    floor: Spread
    ratio: Spread  # ours / floor, of times
    speed: Spread  # of rates: floor / ours


def seconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def paired(ours: Callable[[], object], floor: Callable[[], object], times: int) -> Pair:
    """Measure both in turn, so that other load of the machine affects both alike."""
    if times > 1:
        ours(), floor()  # warms caches
    turns = [(seconds(ours), seconds(floor)) for _ in range(times)]
    return pair_of(turns)


def pair_of(turns: Iterable[tuple[float, float]]) -> Pair:
    """Make a pair from the seconds (ours, floor) of each turn."""
    pairs = list(turns)
    return Pair(
        ours=Spread.of(ours for ours, _ in pairs),
        floor=Spread.of(floor for _, floor in pairs),
        ratio=Spread.of(ours / floor for ours, floor in pairs),
        speed=Spread.of(floor / ours for ours, floor in pairs),
    )


def repeated(call: Callable[[], object], times: int) -> Spread:
    return Spread.of(seconds(call) for _ in range(times))


def peer(
    scale: Scale, what: str, script: str, *arguments: object, unit: str, floor: Spread | None = None
) -> Figure:
    """Run `peers/SCRIPT.py`, which prints a JSON list of its measurements in the unit."""
    values, note = scale.peers.run(script, *arguments)
    if not values:
        return Figure(what, None, unit, "peer", note=note)
    value = Spread.of(values)
    ratio = value.per(floor.median) if floor else None
    return Figure(what, value, unit, "peer", ratio)


def fresh(*arguments: object) -> str:
    """Run Python in a fresh process, from compiled code; return its output.

    With PYTHONDONTWRITEBYTECODE every start would compile our sources again. The first start after
    a change compiles them and must not be measured.
    """
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    process = subprocess.run(
        [sys.executable, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    )
    return process.stdout


def calls(call: Callable[[], object]) -> int:
    """Return the number of calls of Python and C functions in this thread."""
    count = 0

    def count_call(_frame: object, event: str, _what: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(count_call)
    try:
        call()
    finally:
        sys.setprofile(before)
    return count


def allocated_peak(call: Callable[[], object]) -> int:
    """Return the peak of allocated bytes during a call, beyond those before."""
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        call()
        return tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()
