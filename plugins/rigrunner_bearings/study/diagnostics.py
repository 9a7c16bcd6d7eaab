"""A study of the diagnostics: how often each cries wolf on healthy rigs, and misses broken ones."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner_bearings.study.breaks import BREAKS, REFUSED
from rigrunner_bearings.study.diagnostics_case import Finding, cases, examine
from rigrunner_bearings.study.share import Share

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner_bearings.study.breaks import Break
    from rigrunner_bearings.study.going import Going


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
    return Study(
        healthy=len(healthy),
        alarms={
            check: {name: _share(rigs, check) for name, rigs in per_simulator.items()}
            for check in checks
        },
        error={name: _error(rigs) for name, rigs in per_simulator.items()},
        breaks=tuple(
            _row(fault, rigs)
            for fault in BREAKS
            if (rigs := [each for each in everything if each.case.fault == fault.name])
        ),
    )


def _share(rigs: Sequence[Finding], check: str) -> Share:
    return Share(sum(check in each.failed for each in rigs), len(rigs))


def _row(fault: Break, rigs: Sequence[Finding]) -> BreakRow:
    missed = None
    if fault.seen_by:
        seen_by = {fault.seen_by, REFUSED}
        missed = Share(sum(seen_by.isdisjoint(each.failed) for each in rigs), len(rigs))
    others = Counter(name for each in rigs for name in each.failed if name != fault.seen_by)
    return BreakRow(fault, missed, others, _error(rigs))


def _error(rigs: Iterable[Finding]) -> Error | None:
    errors = [each.error_nm for each in rigs if each.error_nm is not None]
    if not errors:
        return None
    return Error(sqrt(sum(e**2 for e in errors) / len(errors)), max(map(abs, errors)))
