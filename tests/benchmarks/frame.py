"""What a benchmark is made of: figures with spread, ratios of pairs, targets, counted work."""

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
    """How much a benchmark is to do, and where other projects' programs are to be found."""

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
        many = sorted(values)
        if len(many) == 1:
            return cls(many[0], many[0], many[0])
        low, median, high = quantiles(many, n=4, method="inclusive")
        return cls(median, low, high)

    def per(self, count: float) -> Spread:
        """Return it divided: seconds of a loop to seconds of a turn, or into other units."""
        return Spread(self.median / count, self.low / count, self.high / count)

    def rate(self, count: float) -> Spread:
        """Return how many were done in a unit of time, from the time that `count` took."""
        return Spread(count / self.median, count / self.high, count / self.low)


@dataclass(frozen=True)
class Target:
    """What is asked of a figure: of its ratio to the floor, or of its value if a unit is given."""

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
    """One row: what was measured; `value` is None for what could not be, and `note` says why."""

    what: str
    value: Spread | None
    unit: str
    role: str = "ours"  # or "floor", or "peer"
    ratio: Spread | None = None
    target: Target | None = None
    note: str = ""  # for ours: what limits it

    def met(self) -> bool | None:
        """Say whether the median is at its target: None where there is none, or no value."""
        of = self.value if self.target and self.target.unit else self.ratio
        return None if self.target is None or of is None else self.target.met(of.median)


@dataclass(frozen=True)
class Work:
    """Work of the short form that does not depend on the machine, and what it may be at most."""

    what: str
    counted: float
    at_most: float


@dataclass(frozen=True)
class Pair:
    """Seconds of ours and of the floor, and the ratios of ours to the floor, turn by turn."""

    ours: Spread
    floor: Spread
    ratio: Spread  # of times; what does n times the work at once has a ratio of 1/n
    speed: Spread  # of rates: floor / ours


def seconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def paired(ours: Callable[[], object], floor: Callable[[], object], times: int) -> Pair:
    """Measure both in turn, so that what else the machine does meets both alike."""
    if times > 1:
        ours(), floor()  # the first time of each warms caches
    turns = [(seconds(ours), seconds(floor)) for _ in range(times)]
    return pair_of(turns)


def pair_of(turns: Iterable[tuple[float, float]]) -> Pair:
    """Make a pair of seconds measured otherwise: (ours, floor) of each turn."""
    many = list(turns)
    return Pair(
        ours=Spread.of(ours for ours, _ in many),
        floor=Spread.of(floor for _, floor in many),
        ratio=Spread.of(ours / floor for ours, floor in many),
        speed=Spread.of(floor / ours for ours, floor in many),
    )


def repeated(call: Callable[[], object], times: int) -> Spread:
    return Spread.of(seconds(call) for _ in range(times))


def peer(
    scale: Scale, what: str, script: str, *arguments: object, unit: str, floor: Spread | None = None
) -> Figure:
    """Run `peers/SCRIPT.py`, which prints a JSON list of what it measured, in the unit."""
    values, why = scale.peers.run(script, *arguments)
    if not values:
        return Figure(what, None, unit, "peer", note=why)
    value = Spread.of(values)
    ratio = value.per(floor.median) if floor else None
    return Figure(what, value, unit, "peer", ratio)


def fresh(*words: object) -> str:
    """Run Python in a fresh process, from compiled code; return what it prints.

    Where Python is told to write none (PYTHONDONTWRITEBYTECODE), every start compiles our sources
    again. The first start after a change compiles them: it is not to be measured.
    """
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    process = subprocess.run(
        [sys.executable, *map(str, words)],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    )
    return process.stdout


def calls(call: Callable[[], object]) -> int:
    """Count calls of functions, of Python and of C, in this thread."""
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
    """Return the most bytes that were allocated at once, beyond those before."""
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        call()
        return tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()
