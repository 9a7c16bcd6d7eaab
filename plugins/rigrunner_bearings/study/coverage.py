"""A study of coverage: errors of results, and how often their interval contains the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Estimate
from rigrunner.api.settings import own_keys
from rigrunner.signal.coverage import excess_kurtosis, expanded
from rigrunner.signal.uncertainty import combine
from rigrunner_bearings.api.rig import RigDescription
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.study.bench import LOAD_N
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.coverage_rigs import (
    FREQUENCIES_HZ,
    LAWS,
    NATURAL_HZ,
    RANGES,
    Limits,
    draw,
)
from rigrunner_bearings.study.recording import record_bench
from rigrunner_bearings.study.share import Share, clustered
from rigrunner_bearings.study.tools import tools
from rigrunner_bearings.torque.headline import compensated_mean
from rigrunner_bearings.torque.settings import CompensationRef

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.study.bench import Bench
    from rigrunner_bearings.study.case_runner import CaseRunner
    from rigrunner_bearings.study.coverage_rigs import Rig
    from rigrunner_bearings.study.share import Clustered

METHODS = ("template_inverse", "model_inverse")


@dataclass(frozen=True)
class Outcome:
    """The results of one method on one rig, against the truth; N·m, one value per set-point."""

    error_nm: tuple[float, ...]
    u_nm: tuple[float, ...]
    expanded_nm: tuple[float, ...]
    """The half-width of the 95 % interval."""
    mean_error_nm: float
    """Error of the mean over the set-points, the result of the run."""
    mean_expanded_nm: float


@dataclass(frozen=True)
class Finding:
    """The outcomes of one rig; a method that was refused has none."""

    case: Case
    law: str
    natural_hz: float
    all_errors: dict[str, Outcome]
    """By method, for recordings with all errors."""
    no_sensor: dict[str, Outcome]
    """The same without the sensor's constant errors, and without their part of the budget."""


def cases(rigs: int, study_seed: int) -> Iterator[Case]:
    """Yield so many rigs of each simulator, in turn."""
    for number in range(rigs):
        yield from (Case(simulator, "", study_seed, number) for simulator in RANGES)


def examine(case: Case) -> Finding:
    """Record and analyse one rig; the same case gives the same finding."""
    rng = case.rng(f"coverage/{case.simulator}")
    rig = draw(case.simulator, rng, tools().measured_station, limits())
    return Finding(
        case,
        rig.law,
        rig.natural_hz,
        all_errors=_outcomes(rig, rig.bench, sensor=True),
        no_sensor=_outcomes(rig, rig.without_sensor_errors, sensor=False),
    )


@lru_cache(maxsize=1)
def limits() -> Limits:
    """Return the limits of the rig's errors, by the primary method's budget and the station."""
    settings = tools().registry.settings_of("compensation", METHODS[0])().model_dump()
    rig = own_keys(RigDescription, tools().measured_station.rig)
    settings["load_tolerance"] = rig.load_tolerance
    settings["support_load_dependence"] = rig.support_load_dependence
    return Limits(**{name: settings[name] for name in Limits.__annotations__})


def is_sensor(component: str) -> bool:
    """Return whether a line of the budget is one of the sensor's constant errors."""
    return component.startswith(("sensor", "zero"))


def _outcomes(rig: Rig, bench: Bench, *, sensor: bool) -> dict[str, Outcome]:
    shared = tools()
    bench_runs = record_bench(bench, shared.registry, rig.station)
    methods = tuple(CompensationRef.model_validate(name) for name in METHODS)
    changes = {"compensations": methods, "primary_": METHODS[0], "fits": ()}
    result = shared.analysed(bench_runs, shared.spec.model_copy(update=changes))
    # Results are for the stated load, and friction is proportional to the load.
    truths = np.array(bench_runs.truths_nm) * LOAD_N / bench.load_n
    points = {name: each.points for name, each in TorqueDetails.of(result).compensations.items()}
    if not sensor:
        points = {name: tuple(map(_without_sensor_lines, each)) for name, each in points.items()}
    return {name: _outcome(each, truths) for name, each in points.items() if each}


def _without_sensor_lines(point: CompensatedPoint) -> CompensatedPoint:
    components = tuple(part for part in point.components if not is_sensor(part.name))
    u, dof = combine(components)
    kurtosis = excess_kurtosis(((part.u, part.distribution) for part in components), u)
    torque = Estimate(point.torque.value, u, dof, point.torque.unit, kurtosis)
    return replace(point, components=components, torque=torque, model=None)


def _outcome(points: Sequence[CompensatedPoint], truths: np.ndarray) -> Outcome:
    torques = [point.torque for point in points]
    mean = compensated_mean(points)
    return Outcome(
        error_nm=tuple(float(t.value - true) for t, true in zip(torques, truths, strict=True)),
        u_nm=tuple(t.u for t in torques),
        expanded_nm=tuple(map(expanded, torques)),
        mean_error_nm=float(mean.value - truths.mean()),
        mean_expanded_nm=expanded(mean),
    )


BANDS_HZ = tuple(pairwise((NATURAL_HZ[0], 300.0, 450.0, 600.0, NATURAL_HZ[1])))
"""The strata of natural frequency."""

BOTH = "both"


@dataclass(frozen=True)
class Spread:
    """The errors of torques in N·m; the percentiles are those of the magnitude."""

    bias: float
    rms: float
    p95: float
    p99: float
    largest: float


@dataclass(frozen=True)
class Row:
    """The results of one method on one group of rigs."""

    method: str
    simulator: str
    sensor: bool
    """Whether with the sensor's constant errors and their part of the budget."""
    rigs: int
    error: Spread
    """Errors at the set-points."""
    coverage: Clustered
    """Coverage at the set-points."""
    mean_coverage: Share
    """Coverage of a run's result, the mean over the set-points."""
    error_over_u: float
    """The rms of a set-point's error over its standard uncertainty: 1 if that is right."""


@dataclass(frozen=True)
class Stratum:
    """The coverage at one frequency, on rigs with a resonance in one band."""

    method: str
    sensor: bool
    band_hz: tuple[float, float]
    frequency_hz: float
    coverage: Share
    error: Spread


@dataclass(frozen=True, eq=False)
class Sample:
    """All results of one method; arrays of shape (rigs, set-points), in N·m."""

    method: str
    sensor: bool
    simulator: Sequence[str]
    law: Sequence[str]
    natural_hz: Array
    error_nm: Array
    u_nm: Array
    expanded_nm: Array
    mean_error_nm: Array
    """Shape (rigs,)."""
    mean_expanded_nm: Array

    @property
    def covered(self) -> Array:
        """1 where the interval contains the true value, else 0."""
        return np.asarray(np.abs(self.error_nm) <= self.expanded_nm, dtype=float)


@dataclass(frozen=True)
class Study:
    """The results of a study."""

    rigs: int
    refused: int
    """Rigs on which a method could not be used; they are in no table."""
    rows: tuple[Row, ...]
    laws: tuple[Row, ...]
    """The rows of the primary method by the bearing's law, in place of the simulator."""
    strata: tuple[Stratum, ...]
    frequencies: tuple[Stratum, ...]
    samples: tuple[Sample, ...]


def run_coverage(*, rigs: int, seed: int, runner: CaseRunner) -> Study:
    """Examine `rigs` rigs of each simulator.

    The same seed gives the same study, on any workers. Raises AbortedError once it is stopped.
    """
    return tally(runner.findings("coverage", examine, Finding, list(cases(rigs, seed))))


def tally(findings: Iterable[Finding]) -> Study:
    """Return the study of some findings; raise DataError if every rig was refused."""
    everything = list(findings)
    used = [f for f in everything if len(f.all_errors) == len(f.no_sensor) == len(METHODS)]
    if not used:
        raise DataError(
            f"no method could be used on any of the {len(everything)} rigs",
            hint="this is a fault of the program: please report it",
        )
    samples = tuple(_sample(used, method, sensor) for method in METHODS for sensor in (True, False))
    return Study(
        rigs=len(used),
        refused=len(everything) - len(used),
        rows=tuple(row for sample in samples for row in _rows(sample)),
        laws=tuple(row for sample in samples[:2] for row in _laws(sample)),
        strata=tuple(
            stratum for sample in samples for band in BANDS_HZ for stratum in _strata(sample, band)
        ),
        frequencies=tuple(s for sample in samples for s in _strata(sample, NATURAL_HZ)),
        samples=samples,
    )


def _sample(findings: Sequence[Finding], method: str, sensor: bool) -> Sample:  # noqa: FBT001  (a field)
    outcomes: list[Outcome] = [(f.all_errors if sensor else f.no_sensor)[method] for f in findings]
    return Sample(
        method=method,
        sensor=sensor,
        simulator=[finding.case.simulator for finding in findings],
        law=[finding.law for finding in findings],
        natural_hz=np.array([finding.natural_hz for finding in findings]),
        error_nm=np.array([outcome.error_nm for outcome in outcomes]),
        u_nm=np.array([outcome.u_nm for outcome in outcomes]),
        expanded_nm=np.array([outcome.expanded_nm for outcome in outcomes]),
        mean_error_nm=np.array([outcome.mean_error_nm for outcome in outcomes]),
        mean_expanded_nm=np.array([outcome.mean_expanded_nm for outcome in outcomes]),
    )


def _rows(sample: Sample) -> Iterable[Row]:
    names = np.array(sample.simulator)
    yield _row(sample, BOTH, np.ones(len(names), bool))
    yield from (_row(sample, name, names == name) for name in RANGES if name in names)


def _laws(sample: Sample) -> Iterable[Row]:
    pairs = np.array([f"{s}: {law}" for s, law in zip(sample.simulator, sample.law, strict=True)])
    labels = [f"{simulator}: {law}" for simulator, laws in LAWS.items() for law in laws]
    yield from (_row(sample, label, pairs == label) for label in labels if label in pairs)


def _row(sample: Sample, name: str, mask: Array) -> Row:
    error = sample.error_nm[mask]
    mean_covered = np.abs(sample.mean_error_nm[mask]) <= sample.mean_expanded_nm[mask]
    return Row(
        method=sample.method,
        simulator=name,
        sensor=sample.sensor,
        rigs=len(error),
        error=_spread(error),
        coverage=clustered(sample.covered[mask]),
        mean_coverage=Share(int(mean_covered.sum()), len(mean_covered)),
        error_over_u=float(np.sqrt(np.mean((error / sample.u_nm[mask]) ** 2))),
    )


def _strata(sample: Sample, band_hz: tuple[float, float]) -> Iterable[Stratum]:
    """Yield one stratum per frequency; the band includes its lower limit."""
    low, high = band_hz
    mask = (sample.natural_hz >= low) & (sample.natural_hz < high)
    if not mask.any():
        return
    for i, frequency in enumerate(FREQUENCIES_HZ):
        covered = sample.covered[mask, i]
        yield Stratum(
            method=sample.method,
            sensor=sample.sensor,
            band_hz=band_hz,
            frequency_hz=frequency,
            coverage=Share(int(covered.sum()), len(covered)),
            error=_spread(sample.error_nm[mask, i]),
        )


def _spread(error_nm: Array) -> Spread:
    magnitude = np.abs(error_nm)
    p95, p99 = np.quantile(magnitude, [0.95, 0.99])
    return Spread(
        bias=float(error_nm.mean()),
        rms=float(np.sqrt(np.mean(error_nm**2))),
        p95=float(p95),
        p99=float(p99),
        largest=float(magnitude.max()),
    )
