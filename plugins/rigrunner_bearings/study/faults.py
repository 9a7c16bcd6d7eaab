"""A study of faults: how many results are wrong beyond their uncertainty without a flag."""

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
    from rigrunner_bearings.study.case_runner import CaseRunner
    from rigrunner_bearings.study.fault_kinds import DataFault
    from rigrunner_bearings.study.recording import RecordedBench

RECORDING, ANALYSIS, CRASH = "(recording failed)", "(refused)", "(crashed)"
"""In place of checks: refused by the engine, refused by the analysis, a crash of the analysis."""

RUNS = ("no load", "loaded", "both")
UNSEEN_CASES = 10


@dataclass(frozen=True)
class Finding:
    """The results of a case."""

    case: Case
    answers: tuple[str, ...]
    """The checks that failed, or what refused it."""
    where: str = ""
    """Fault, run and set-point in words."""
    ratio: float | None = None
    """Error over stated expanded uncertainty (95 %) of the result, the mean over the set-points."""
    worst_ratio: float | None = None
    """The same at the worst set-point."""


def cases(faulty: int, study_seed: int) -> Iterator[Case]:
    """Yield `faulty` cases, half as many clean ones, and those of faults that no data can show."""
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
    fault = next((fault for fault in (*FAULTS, *UNSEEN) if fault.name == case.fault), None)
    faults, where = (NO_FAULTS, "") if fault is None else _drawn(fault, rig.bench, rng)
    try:
        bench_runs = record_bench(rig.bench, tools().registry, rig.station, faults)
        result = tools().analysed(bench_runs, primary_alone(tools().spec))
        return _finding(case, where, bench_runs, result)
    except DeviceError:
        return Finding(case, (RECORDING,), where)
    except DataError:
        return Finding(case, (ANALYSIS,), where)
    except Exception as error:  # noqa: BLE001  (a bug, and one that the study is there to find)
        return Finding(case, (CRASH,), f"{where}: {type(error).__name__}: {error}")


def _drawn(fault: DataFault, bench: Bench, rng: Generator) -> tuple[Faults, str]:
    """Return the fault in one run or in both, at one set-point or at all of them."""
    settings = dict(fault.draw(rng))
    run = "both" if fault.both_runs else str(rng.choice(RUNS))
    everywhere = fault.both_runs or bool(rng.integers(2))
    hz = float(rng.choice(bench.frequencies_hz))
    where = f"{settings}, {run}, all set-points"
    if not everywhere:
        # A frequency is set before it is reached: the fault of a drive is given by its call.
        nth = bench.frequencies_hz.index(hz) + 1
        place = {"at": {"frequency": f"{hz:g} Hz"}}
        settings |= {"calls": [nth]} if settings["kind"] == "wrong frequency" else place
        where = f"{settings}, {run}"
    if settings["kind"] == "wrong frequency":
        settings["drive"] = "frequency"
    entry = (settings,)
    seed = int(rng.integers(2**31))
    return Faults(entry if run != "loaded" else (), entry if run != "no load" else (), seed), where


def _finding(case: Case, where: str, bench_runs: RecordedBench, result: Result) -> Finding:
    torque = TorqueDetails.of(result)
    primary = torque.compensations[torque.primary]
    if primary.not_applicable or result.headline is None:
        return Finding(case, (ANALYSIS,), where)
    pairs = zip(primary.points, bench_runs.truths_nm, strict=True)
    return Finding(
        case,
        tuple(sorted({checked_by(check) for check in checks_of(result) if not check.ok})),
        where,
        _ratio(result.headline, bench_runs.truth_nm),
        max((_ratio(point.torque, truth) for point, truth in pairs), key=abs),
    )


def _ratio(estimate: Estimate, truth_nm: float) -> float:
    return float((estimate.value - truth_nm) / (estimate.u * coverage_factor(estimate.dof)))


FAR = 2.0
"""Times the stated expanded uncertainty."""


@dataclass(frozen=True)
class Silent:
    """Results that no check flagged, by error over stated expanded uncertainty."""

    within: int
    """Number up to 1."""
    beyond: int
    """Number from 1 to 2."""
    far_beyond: int
    """Number above 2: wrong results that nothing reports."""
    worst: float
    worst_point: float
    """The worst ratio of a single set-point."""

    @property
    def count(self) -> int:
        """Number of results."""
        return self.within + self.beyond + self.far_beyond

    @property
    def share_beyond(self) -> Share:
        """Share of them beyond the stated uncertainty, but not far."""
        return Share(self.beyond, self.count)


@dataclass(frozen=True)
class FaultRow:
    """The results of the cases with one fault."""

    fault: DataFault
    cases: int
    recording_failed: int
    refused: int
    flagged: Counter[str]
    """How often each check failed."""
    flagged_cases: int
    silent: Silent


@dataclass(frozen=True)
class Study:
    """The results of a study."""

    cases: int
    rows: tuple[FaultRow, ...]
    """Faults that data can show."""
    unseen: tuple[FaultRow, ...]
    silent: Silent
    """Results of all rows."""
    clean: Silent
    clean_flagged: int
    wrong: tuple[Finding, ...]
    """The cases that no check flagged, with an error above twice the stated uncertainty."""
    crashed: tuple[Finding, ...]
    """The cases at which the analysis crashed: bugs."""


def run_faults(
    *,
    cases_wanted: int,
    seed: int,
    runner: CaseRunner,
) -> Study:
    """Examine faulty cases, and half as many clean ones.

    The same seed gives the same study, on any workers. Raises AbortedError once it is stopped.
    """
    all_cases = list(cases(cases_wanted, seed))
    return tally(runner.findings("faults", examine, Finding, all_cases))


def tally(findings: Iterable[Finding]) -> Study:
    """Return the study of some findings."""
    everything = list(findings)
    names = {fault.name for fault in FAULTS}
    faulty = [finding for finding in everything if finding.case.fault in names]
    clean = [finding for finding in everything if not finding.case.fault]
    return Study(
        cases=len(faulty),
        rows=_rows(FAULTS, everything),
        unseen=_rows(UNSEEN, everything),
        silent=_silent(faulty),
        clean=_silent(clean),
        clean_flagged=sum(bool(finding.answers) for finding in clean),
        wrong=tuple(f for f in faulty if _is_silent(f) and abs(f.ratio or 0) > FAR),
        crashed=tuple(finding for finding in everything if CRASH in finding.answers),
    )


def _rows(faults: Sequence[DataFault], findings: Sequence[Finding]) -> tuple[FaultRow, ...]:
    rows = []
    for fault in faults:
        group = [finding for finding in findings if finding.case.fault == fault.name]
        failed = sum(RECORDING in finding.answers for finding in group)
        refused = sum(ANALYSIS in finding.answers for finding in group)
        flagged = [finding for finding in group if finding.answers and finding.ratio is not None]
        names = Counter(name for finding in flagged for name in finding.answers)
        if group:
            silent = _silent(group)
            rows.append(FaultRow(fault, len(group), failed, refused, names, len(flagged), silent))
    return tuple(rows)


def _is_silent(finding: Finding) -> bool:
    return not finding.answers and finding.ratio is not None


def _silent(findings: Sequence[Finding]) -> Silent:
    silent = [finding for finding in findings if _is_silent(finding)]
    ratios = [abs(finding.ratio or 0.0) for finding in silent]
    return Silent(
        within=sum(ratio <= 1 for ratio in ratios),
        beyond=sum(1 < ratio <= FAR for ratio in ratios),
        far_beyond=sum(ratio > FAR for ratio in ratios),
        worst=max(ratios, default=0.0),
        worst_point=max((abs(finding.worst_ratio or 0.0) for finding in silent), default=0.0),
    )
