"""A study of the diagnostics: how often each cries wolf on healthy rigs, and misses broken ones."""

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
    from rigrunner_bearings.study.going import Going


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
    spec = primary_alone(shared.spec)
    rng = case.rng(f"{case.simulator}/{case.fault}")
    bench = healthy(case.simulator, int(rng.integers(2**31)), rng)
    if fault is not None:
        bench = fault.apply(bench, rng)
        if fault.before_compensation:
            spec = spec.model_copy(update={"compensations": (), "primary_": None})
    recorded = record_bench(bench, shared.registry, shared.measured_station)
    try:
        result = shared.analysed(recorded, spec)
    except DataError:
        return Finding(case, (REFUSED,), (REFUSED,))
    checks = [(checked_by(check), check) for check in checks_of(result)]
    failed = {name for name, check in checks if not check.ok}
    if any(each.not_applicable for each in TorqueDetails.of(result).compensations.values()):
        failed.add(REFUSED)
    made = {name for name, check in checks if check.value is not None}
    error = None if result.headline is None else result.headline.value - recorded.truth_nm
    return Finding(case, tuple(sorted(failed)), tuple(sorted(made)), error)


@dataclass(frozen=True)
class Error:
    """What the primary method's mean erred by in N·m, over some rigs."""

    rms_nm: float
    largest_nm: float


@dataclass(frozen=True)
class BreakRow:
    """What became of the rigs with one break."""

    fault: Break
    missed: Share | None
    """Neither flagged by the check that is to see it nor refused; None where no check can."""
    others: Counter[str]
    """How often other checks flagged something."""
    error: Error | None


@dataclass(frozen=True)
class Study:
    """What a study found."""

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
    going: Going,
) -> Study:
    """Examine so many healthy rigs of each simulator and so many of each break.

    The same seed gives the same study, whoever does it. Raises AbortedError once it is stopped.
    """
    wanted = list(cases(healthy_rigs, broken_rigs, seed))
    return tally(going.findings("diagnostics", examine, Finding, wanted))


def tally(findings: Iterable[Finding]) -> Study:
    """Return what the findings come to."""
    everything = list(findings)
    healthy = [each for each in everything if not each.case.fault]
    simulators = sorted({each.case.simulator for each in healthy})
    per_simulator = {name: [e for e in healthy if e.case.simulator == name] for name in simulators}
    checks = sorted({name for each in healthy for name in each.made})
    rows = []
    for fault in BREAKS:
        broken = [each for each in everything if each.case.fault == fault.name]
        if broken:
            missed = None
            if fault.seen_by:
                seen_by = {fault.seen_by, REFUSED}
                count = sum(seen_by.isdisjoint(each.failed) for each in broken)
                missed = Share(count, len(broken))
            failed = (name for each in broken for name in each.failed)
            others = Counter(name for name in failed if name != fault.seen_by)
            rows.append(BreakRow(fault, missed, others, _error(broken)))
    return Study(
        healthy=len(healthy),
        alarms={
            check: {
                name: Share(sum(check in each.failed for each in rigs), len(rigs))
                for name, rigs in per_simulator.items()
            }
            for check in checks
        },
        error={name: _error(rigs) for name, rigs in per_simulator.items()},
        breaks=tuple(rows),
    )


def _error(rigs: Iterable[Finding]) -> Error | None:
    errors = [each.error_nm for each in rigs if each.error_nm is not None]
    if not errors:
        return None
    return Error(sqrt(sum(e**2 for e in errors) / len(errors)), max(map(abs, errors)))
