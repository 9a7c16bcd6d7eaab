"""One case of the study of faults: a rig recorded with a fault, and what became of the result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.analysis.torque.diagnosis import checked_by
from rigrunner.api import DataError, DeviceError, TorqueDetails
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.coverage_case import limits
from rigrunner_bearings.study.coverage_rigs import RANGES, draw
from rigrunner_bearings.study.fault_kinds import FAULTS, UNSEEN
from rigrunner_bearings.study.recording import NO_FAULTS, Faults, record_bench
from rigrunner_bearings.study.tools import checks_of, primary_alone, tools

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.random import Generator

    from rigrunner.api import Estimate
    from rigrunner.api.results import Result
    from rigrunner_bearings.study.bench import Bench
    from rigrunner_bearings.study.fault_kinds import DataFault
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
        return _finding(case, where, recorded, _analysed(recorded))
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


def _analysed(recorded: RecordedBench) -> Result:
    return tools().analysed(recorded, primary_alone(tools().spec))


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
