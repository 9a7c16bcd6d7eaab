"""A study of faults: how many results are wrong, beyond what they state, and nothing says so."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_bearings.study.fault_case import (
    ANALYSIS,
    CRASH,
    RECORDING,
    Finding,
    cases,
    examine,
)
from rigrunner_bearings.study.fault_kinds import FAULTS, UNSEEN
from rigrunner_bearings.study.share import Share

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner_bearings.study.fault_kinds import DataFault
    from rigrunner_bearings.study.going import Going

FAR = 2.0
"""Times the stated expanded uncertainty."""


@dataclass(frozen=True)
class Silent:
    """Results that nothing flagged, by error over stated expanded uncertainty."""

    within: int
    """Up to 1."""
    beyond: int
    """From 1 to 2."""
    far_beyond: int
    """Above 2: a wrong result that nothing reports."""
    worst: float
    worst_point: float
    """Of a single set-point."""

    @property
    def count(self) -> int:
        """How many there are."""
        return self.within + self.beyond + self.far_beyond

    @property
    def share_beyond(self) -> Share:
        """How many of them are beyond what is stated, but not far."""
        return Share(self.beyond, self.count)


@dataclass(frozen=True)
class FaultRow:
    """What became of the cases with one fault."""

    fault: DataFault
    cases: int
    recording_failed: int
    refused: int
    flagged: Counter[str]
    """How often each check flagged something."""
    flagged_cases: int
    silent: Silent


@dataclass(frozen=True)
class Study:
    """What a study found."""

    cases: int
    rows: tuple[FaultRow, ...]
    """Of faults that data can show."""
    unseen: tuple[FaultRow, ...]
    silent: Silent
    """Of all rows."""
    clean: Silent
    clean_flagged: int
    wrong: tuple[Finding, ...]
    """The cases that passed in silence with an error above twice the stated uncertainty."""
    crashed: tuple[Finding, ...]
    """The cases that the analysis broke at: bugs."""


def run_faults(
    *,
    cases_wanted: int,
    seed: int,
    going: Going,
) -> Study:
    """Examine so many faulty cases and half as many clean ones.

    The same seed gives the same study, whoever does it. Raises AbortedError once it is stopped.
    """
    wanted = list(cases(cases_wanted, seed))
    return tally(going.findings("faults", examine, Finding, wanted))


def tally(findings: Iterable[Finding]) -> Study:
    """Return what the findings come to."""
    everything = list(findings)
    known = {each.name for each in FAULTS}
    faulty = [each for each in everything if each.case.fault in known]
    clean = [each for each in everything if not each.case.fault]
    return Study(
        cases=len(faulty),
        rows=_rows(FAULTS, everything),
        unseen=_rows(UNSEEN, everything),
        silent=_silent(faulty),
        clean=_silent(clean),
        clean_flagged=sum(bool(each.answers) for each in clean),
        wrong=tuple(each for each in faulty if _is_silent(each) and abs(each.ratio or 0) > FAR),
        crashed=tuple(each for each in everything if CRASH in each.answers),
    )


def _rows(faults: Sequence[DataFault], findings: Sequence[Finding]) -> tuple[FaultRow, ...]:
    return tuple(
        _row(fault, found)
        for fault in faults
        if (found := [each for each in findings if each.case.fault == fault.name])
    )


def _row(fault: DataFault, found: Sequence[Finding]) -> FaultRow:
    failed = sum(RECORDING in each.answers for each in found)
    refused = sum(ANALYSIS in each.answers for each in found)
    flagged = [each for each in found if each.answers and each.ratio is not None]
    names = Counter(name for each in flagged for name in each.answers)
    return FaultRow(fault, len(found), failed, refused, names, len(flagged), _silent(found))


def _is_silent(finding: Finding) -> bool:
    return not finding.answers and finding.ratio is not None


def _silent(findings: Sequence[Finding]) -> Silent:
    silent = [each for each in findings if _is_silent(each)]
    ratios = [abs(each.ratio or 0.0) for each in silent]
    return Silent(
        within=sum(ratio <= 1 for ratio in ratios),
        beyond=sum(1 < ratio <= FAR for ratio in ratios),
        far_beyond=sum(ratio > FAR for ratio in ratios),
        worst=max(ratios, default=0.0),
        worst_point=max((abs(each.worst_ratio or 0.0) for each in silent), default=0.0),
    )
