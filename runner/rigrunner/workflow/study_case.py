"""One rig of a study: both runs recorded in memory, analysed as any run, and what was flagged."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.analyse import analyse
from rigrunner.api.errors import DataError
from rigrunner.procedure import load_procedure
from rigrunner.registry import load_registry
from rigrunner.station import load_station
from rigrunner.workflow.locate import find_procedure, find_station
from rigrunner.workflow.study_breaks import BREAKS, REFUSED
from rigrunner.workflow.study_recording import record_bench
from rigrunner.workflow.study_rigs import POPULATIONS, healthy

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.results import Result
    from rigrunner.procedure import AnalysisSpec, Measurand
    from rigrunner.registry import Registry
    from rigrunner.station import Station
    from rigrunner.workflow.study_breaks import Break
    from rigrunner.workflow.study_recording import RecordedBench
    from rigrunner.workflow.study_rigs import Bench

PROCEDURE, STATION = "starting_torque_1000n", "simulated"
NO_LOAD_PREFIX = "no-load run: "


@dataclass(frozen=True)
class Case:
    """Names one rig of a study: the same names give the same rig."""

    simulator: str
    fault: str
    """The name of a break; empty for a healthy rig."""
    study_seed: int
    number: int


@dataclass(frozen=True)
class Finding:
    """What the analysis made of one rig."""

    case: Case
    failed: tuple[str, ...]
    """The checks that flagged something."""
    made: tuple[str, ...]
    """All that were made; those that were skipped are not among them."""
    error_nm: float | None = None
    """Of the primary method's mean, against the simulator's truth; None where there is none."""


@dataclass(frozen=True, eq=False)
class _Tools:
    station: Station
    spec: AnalysisSpec
    measurand: Measurand
    registry: Registry

    def analysed(self, recorded: RecordedBench, spec: AnalysisSpec) -> Result:
        return analyse(
            recorded.loaded,
            recorded.no_load,
            spec,
            acceptance=None,
            measurand=self.measurand,
            lookup=self.registry,
        )


def cases(healthy_rigs: int, broken_rigs: int, study_seed: int) -> Iterator[Case]:
    """Yield healthy rigs of each simulator, and rigs of each break, half of them on each."""
    for simulator in POPULATIONS:
        yield from (Case(simulator, "", study_seed, number) for number in range(healthy_rigs))
    for fault in BREAKS:
        for number in range(broken_rigs):
            simulator = fault.simulators[number % len(fault.simulators)]
            yield Case(simulator, fault.name, study_seed, number)


def examine(case: Case) -> Finding:
    """Record and analyse one rig; the same case gives the same finding."""
    fault = next((each for each in BREAKS if each.name == case.fault), None)
    tools = _tools()
    bench = _bench(case, fault)
    recorded = record_bench(bench, tools.registry, tools.station)
    try:
        result = tools.analysed(recorded, _spec(tools.spec, fault))
    except DataError:
        return Finding(case, (REFUSED,), (REFUSED,))
    return _finding(case, result, recorded.truth_nm)


@lru_cache(maxsize=1)
def _tools() -> _Tools:
    procedure = load_procedure(find_procedure(PROCEDURE)).model
    station = load_station(find_station(STATION)).model
    return _Tools(station, procedure.analysis, procedure.measurand, load_registry())


def _bench(case: Case, fault: Break | None) -> Bench:
    words = zlib.crc32(f"{case.simulator}/{case.fault}".encode())
    rng = np.random.default_rng([case.study_seed, words, case.number])
    bench = healthy(case.simulator, int(rng.integers(2**31)), rng)
    return bench if fault is None else fault.apply(bench, rng)


def _spec(spec: AnalysisSpec, fault: Break | None) -> AnalysisSpec:
    """Return the procedure's analysis with its primary method alone, or none where none is due."""
    if fault is not None and fault.before_compensation:
        return spec.model_copy(update={"compensations": (), "primary_": None})
    primary = tuple(each for each in spec.compensations if each.name == spec.primary)
    return spec.model_copy(update={"compensations": primary})


def _finding(case: Case, result: Result, truth_nm: float) -> Finding:
    checks = [*result.checks]
    for each in result.compensations.values():
        checks += each.checks
    failed = {check.name.removeprefix(NO_LOAD_PREFIX) for check in checks if not check.ok}
    if any(each.not_applicable for each in result.compensations.values()):
        failed.add(REFUSED)
    made = {c.name.removeprefix(NO_LOAD_PREFIX) for c in checks if c.value is not None}
    error = None if result.headline is None else result.headline.value - truth_nm
    return Finding(case, tuple(sorted(failed)), tuple(sorted(made)), error)
