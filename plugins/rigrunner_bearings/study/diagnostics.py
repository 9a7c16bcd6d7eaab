"""A study of the diagnostics: false alarms of each check on healthy rigs, and missed breaks."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api import DataError
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.study.breaks import BREAKS, REFUSED
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.diagnostics_rigs import POPULATIONS, healthy
from rigrunner_bearings.study.recording import record_bench
from rigrunner_bearings.study.share import Share
from rigrunner_bearings.study.tools import checks_of, primary_alone, tools
from rigrunner_bearings.torque.diagnosis import checked_by

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner_bearings.study.breaks import Break
    from rigrunner_bearings.study.case_runner import CaseRunner


@dataclass(frozen=True)
class Finding:
    """The results of the analysis of one rig."""

    case: Case
    failed: tuple[str, ...]
    """The checks that flagged something."""
    performed: tuple[str, ...]
    """All checks that were not skipped."""
    error_nm: float | None = None
    """Error of the primary method's mean against the simulator's truth; None without a mean."""


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
    fault = next((fault for fault in BREAKS if fault.name == case.fault), None)
    shared = tools()
    spec = primary_alone(shared.spec)
    rng = case.rng(f"{case.simulator}/{case.fault}")
    bench = healthy(case.simulator, int(rng.integers(2**31)), rng)
    if fault is not None:
        bench = fault.apply(bench, rng)
        if fault.before_compensation:
            spec = spec.model_copy(update={"compensations": (), "primary_": None})
    bench_runs = record_bench(bench, shared.registry, shared.measured_station)
    try:
        result = shared.analysed(bench_runs, spec)
    except DataError:
        return Finding(case, (REFUSED,), (REFUSED,))
    checks = [(checked_by(check), check) for check in checks_of(result)]
    failed = {name for name, check in checks if not check.ok}
    compensations = TorqueDetails.of(result).compensations.values()
    if any(compensation.not_applicable for compensation in compensations):
        failed.add(REFUSED)
    performed = {name for name, check in checks if check.value is not None}
    error = None if result.headline is None else result.headline.value - bench_runs.truth_nm
    return Finding(case, tuple(sorted(failed)), tuple(sorted(performed)), error)


@dataclass(frozen=True)
class Error:
    """The error of the primary method's mean over some rigs, in N·m."""

    rms_nm: float
    largest_nm: float


@dataclass(frozen=True)
class BreakRow:
    """The results of the rigs with one break."""

    fault: Break
    missed: Share | None
    """Neither flagged by the check for it nor refused; None if no check can detect it."""
    others: Counter[str]
    """How often other checks failed."""
    error: Error | None


@dataclass(frozen=True)
class Study:
    """The results of a study."""

    healthy: int
    alarms: dict[str, dict[str, Share]]
    """False alarms by check and simulator."""
    error: dict[str, Error | None]
    """On healthy rigs, by simulator."""
    breaks: tuple[BreakRow, ...]


def run_diagnostics(
    *,
    healthy_rigs: int,
    broken_rigs: int,
    seed: int,
    runner: CaseRunner,
) -> Study:
    """Examine healthy rigs of each simulator, and rigs of each break.

    The same seed gives the same study, on any workers. Raises AbortedError once it is stopped.
    """
    all_cases = list(cases(healthy_rigs, broken_rigs, seed))
    return tally(runner.findings("diagnostics", examine, Finding, all_cases))


def tally(findings: Iterable[Finding]) -> Study:
    """Return the study of some findings."""
    everything = list(findings)
    healthy = [finding for finding in everything if not finding.case.fault]
    simulators = sorted({finding.case.simulator for finding in healthy})
    per_simulator = {name: [f for f in healthy if f.case.simulator == name] for name in simulators}
    checks = sorted({name for finding in healthy for name in finding.performed})
    rows = []
    for fault in BREAKS:
        broken = [finding for finding in everything if finding.case.fault == fault.name]
        if broken:
            missed = None
            if fault.seen_by:
                seen_by = {fault.seen_by, REFUSED}
                count = sum(seen_by.isdisjoint(finding.failed) for finding in broken)
                missed = Share(count, len(broken))
            failed = (name for finding in broken for name in finding.failed)
            other_checks = Counter(name for name in failed if name != fault.seen_by)
            rows.append(BreakRow(fault, missed, other_checks, _error(broken)))
    return Study(
        healthy=len(healthy),
        alarms={
            check: {
                name: Share(sum(check in finding.failed for finding in rigs), len(rigs))
                for name, rigs in per_simulator.items()
            }
            for check in checks
        },
        error={name: _error(rigs) for name, rigs in per_simulator.items()},
        breaks=tuple(rows),
    )


def _error(rigs: Iterable[Finding]) -> Error | None:
    errors = [finding.error_nm for finding in rigs if finding.error_nm is not None]
    if not errors:
        return None
    return Error(sqrt(sum(error**2 for error in errors) / len(errors)), max(map(abs, errors)))
