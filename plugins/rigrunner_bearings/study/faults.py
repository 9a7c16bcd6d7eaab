"""A study of faults: how many results are wrong, beyond what they state, and nothing says so."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api import DataError, DeviceError
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.coverage import limits
from rigrunner_bearings.study.coverage_rigs import RANGES, draw
from rigrunner_bearings.study.fault_kinds import FAULTS, UNSEEN
from rigrunner_bearings.study.recording import NO_FAULTS, Faults, record_bench
from rigrunner_bearings.study.share import Share
from rigrunner_bearings.study.tools import checks_of, primary_alone, tools
from rigrunner_bearings.torque.diagnosis import checked_by

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.random import Generator

    from rigrunner.api import Estimate
    from rigrunner.api.results import Result
    from rigrunner_bearings.study.bench import Bench
    from rigrunner_bearings.study.fault_kinds import DataFault
    from rigrunner_bearings.study.going import Going
    from rigrunner_bearings.study.recording import RecordedBench

RECORDING, ANALYSIS, CRASH = "(recording failed)", "(refused)", "(crashed)"
"""Stand for the answers of the engine and of the analysis, and for an analysis that broke."""

RUNS = ("no load", "loaded", "both")
UNSEEN_CASES = 10


@dataclass(frozen=True)
class Finding:
    """What became of a case."""

    case: Case
    answers: tuple[str, ...]
    """The checks that flagged something, or who refused."""
    where: str = ""
    """Fault, run and set-point in words."""
    ratio: float | None = None
    """Error over stated expanded uncertainty (95 %) of the result, the mean over the set-points."""
    worst_ratio: float | None = None
    """Of the worst set-point."""


def cases(faulty: int, study_seed: int) -> Iterator[Case]:
    """Yield so many faulty cases, half as many clean ones, and those that no data can show."""
    simulators = tuple(RANGES)
    for number in range(faulty):
        fault = FAULTS[number % len(FAULTS)]
        yield Case(_in_turn(simulators, number // len(FAULTS)), fault.name, study_seed, number)
    for number in range((faulty + 1) // 2):
        yield Case(_in_turn(simulators, number), "", study_seed, number)
    for fault in UNSEEN:
        for number in range(min(UNSEEN_CASES, faulty)):
            yield Case(_in_turn(simulators, number), fault.name, study_seed, number)


def _in_turn(simulators: tuple[str, ...], number: int) -> str:
    return simulators[number % len(simulators)]


def examine(case: Case) -> Finding:
    """Record and analyse one case; the same case gives the same finding."""
    rng = case.rng(f"faults/{case.simulator}/{case.fault}")
    rig = draw(case.simulator, rng, tools().measured_station, limits())
    fault = next((each for each in (*FAULTS, *UNSEEN) if each.name == case.fault), None)
    faults, where = (NO_FAULTS, "") if fault is None else _drawn(fault, rig.bench, rng)
    try:
        recorded = record_bench(rig.bench, tools().registry, rig.station, faults)
        result = tools().analysed(recorded, primary_alone(tools().spec))
        return _finding(case, where, recorded, result)
    except DeviceError:
        return Finding(case, (RECORDING,), where)
    except DataError:
        return Finding(case, (ANALYSIS,), where)
    except Exception as error:  # noqa: BLE001  (a bug, and one that the study is there to find)
        return Finding(case, (CRASH,), f"{where}: {type(error).__name__}: {error}")


def _drawn(fault: DataFault, bench: Bench, rng: Generator) -> tuple[Faults, str]:
    """Return the fault in one run or in both, at one set-point or at all of them."""
    told = dict(fault.draw(rng))
    run = "both" if fault.both_runs else str(rng.choice(RUNS))
    everywhere = fault.both_runs or bool(rng.integers(2))
    hz = float(rng.choice(bench.frequencies_hz))
    where = f"{told}, {run}, all set-points"
    if not everywhere:
        # A frequency is set before it is there: the fault of a drive comes by its number.
        nth = bench.frequencies_hz.index(hz) + 1
        at = {"at": {"frequency": f"{hz:g} Hz"}}
        told |= {"calls": [nth]} if told["kind"] == "wrong frequency" else at
        where = f"{told}, {run}"
    if told["kind"] == "wrong frequency":
        told["drive"] = "frequency"
    found = (told,)
    seed = int(rng.integers(2**31))
    return Faults(found if run != "loaded" else (), found if run != "no load" else (), seed), where


def _finding(case: Case, where: str, recorded: RecordedBench, result: Result) -> Finding:
    torque = TorqueDetails.of(result)
    primary = torque.compensations[torque.primary]
    if primary.not_applicable or result.headline is None:
        return Finding(case, (ANALYSIS,), where)
    pairs = zip(primary.points, recorded.truths_nm, strict=True)
    return Finding(
        case,
        tuple(sorted({checked_by(check) for check in checks_of(result) if not check.ok})),
        where,
        _ratio(result.headline, recorded.truth_nm),
        max((_ratio(point.torque, truth) for point, truth in pairs), key=abs),
    )


def _ratio(found: Estimate, truth_nm: float) -> float:
    return float((found.value - truth_nm) / (found.u * coverage_factor(found.dof)))


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
    rows = []
    for fault in faults:
        found = [each for each in findings if each.case.fault == fault.name]
        failed = sum(RECORDING in each.answers for each in found)
        refused = sum(ANALYSIS in each.answers for each in found)
        flagged = [each for each in found if each.answers and each.ratio is not None]
        names = Counter(name for each in flagged for name in each.answers)
        if found:
            silent = _silent(found)
            rows.append(FaultRow(fault, len(found), failed, refused, names, len(flagged), silent))
    return tuple(rows)


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
