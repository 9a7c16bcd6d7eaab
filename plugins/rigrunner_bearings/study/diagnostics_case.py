"""One rig of a study: both runs recorded in memory, analysed as any run, and what was flagged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.analysis.torque.diagnosis import checked_by
from rigrunner.api import DataError, TorqueDetails
from rigrunner_bearings.study.breaks import BREAKS, REFUSED
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.diagnostics_rigs import POPULATIONS, healthy
from rigrunner_bearings.study.recording import record_bench
from rigrunner_bearings.study.tools import checks_of, primary_alone, tools

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.results import Result
    from rigrunner.procedure import AnalysisSpec
    from rigrunner_bearings.study.bench import Bench
    from rigrunner_bearings.study.breaks import Break


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
    shared = tools()
    bench = _bench(case, fault)
    recorded = record_bench(bench, shared.registry, shared.measured_station)
    try:
        result = shared.analysed(recorded, _spec(shared.spec, fault))
    except DataError:
        return Finding(case, (REFUSED,), (REFUSED,))
    return _finding(case, result, recorded.truth_nm)


def _bench(case: Case, fault: Break | None) -> Bench:
    rng = case.rng(f"{case.simulator}/{case.fault}")
    bench = healthy(case.simulator, int(rng.integers(2**31)), rng)
    return bench if fault is None else fault.apply(bench, rng)


def _spec(spec: AnalysisSpec, fault: Break | None) -> AnalysisSpec:
    """Return the procedure's analysis with its primary method alone, or none where none is due."""
    if fault is not None and fault.before_compensation:
        return spec.model_copy(update={"compensations": (), "primary_": None})
    return primary_alone(spec)


def _finding(case: Case, result: Result, truth_nm: float) -> Finding:
    checks = [(checked_by(check), check) for check in checks_of(result)]
    failed = {name for name, check in checks if not check.ok}
    if any(each.not_applicable for each in TorqueDetails.of(result).compensations.values()):
        failed.add(REFUSED)
    made = {name for name, check in checks if check.value is not None}
    error = None if result.headline is None else result.headline.value - truth_nm
    return Finding(case, tuple(sorted(failed)), tuple(sorted(made)), error)
