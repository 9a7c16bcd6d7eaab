"""A study of coverage: how wrong the results are, and how often their interval holds the truth."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner_bearings.study.coverage_case import METHODS, Finding, cases, examine
from rigrunner_bearings.study.coverage_rigs import FREQUENCIES_HZ, LAWS, NATURAL_HZ, RANGES
from rigrunner_bearings.study.share import Share, clustered

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.study.coverage_case import Outcome
    from rigrunner_bearings.study.going import Going
    from rigrunner_bearings.study.share import Clustered

BANDS_HZ = tuple(pairwise((NATURAL_HZ[0], 300.0, 450.0, 600.0, NATURAL_HZ[1])))
"""The strata of natural frequency."""

BOTH = "both"


@dataclass(frozen=True)
class Spread:
    """What torques erred by, in N·m; the percentiles are those of the magnitude."""

    bias: float
    rms: float
    p95: float
    p99: float
    largest: float


@dataclass(frozen=True)
class Row:
    """What became of one method on one group of rigs."""

    method: str
    simulator: str
    sensor: bool
    """With the sensor's constant errors, and with their part of the budget."""
    rigs: int
    error: Spread
    """Of the set-points."""
    held: Clustered
    """How often a set-point's interval holds the truth."""
    mean_held: Share
    """How often that of a run's result, the mean over the set-points, does."""
    error_over_u: float
    """The rms of a set-point's error over its standard uncertainty: 1 if it is stated right."""


@dataclass(frozen=True)
class Stratum:
    """How often the interval holds the truth at one frequency, on rigs of one band of resonance."""

    method: str
    sensor: bool
    band_hz: tuple[float, float]
    frequency_hz: float
    held: Share
    error: Spread


@dataclass(frozen=True, eq=False)
class Sample:
    """Everything that one method said; arrays of shape (rigs, set-points), in N·m."""

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
    def held(self) -> Array:
        """1 where the interval holds the truth, else 0."""
        return np.asarray(np.abs(self.error_nm) <= self.expanded_nm, dtype=float)


@dataclass(frozen=True)
class Study:
    """What a study found."""

    rigs: int
    refused: int
    """Rigs that a method could not be used on; they are in no table."""
    rows: tuple[Row, ...]
    laws: tuple[Row, ...]
    """The rows of the primary method by the bearing's law, which stands for the simulator."""
    strata: tuple[Stratum, ...]
    frequencies: tuple[Stratum, ...]
    samples: tuple[Sample, ...]


def run_coverage(*, rigs: int, seed: int, going: Going) -> Study:
    """Examine so many rigs of each simulator.

    The same seed gives the same study, whoever does it. Raises AbortedError once it is stopped.
    """
    wanted = list(cases(rigs, seed))
    return tally(going.findings("coverage", examine, Finding, wanted))


def tally(findings: Iterable[Finding]) -> Study:
    """Return what the findings come to; raise DataError if every rig was refused."""
    everything = list(findings)
    used = [each for each in everything if len(each.whole) == len(each.no_sensor) == len(METHODS)]
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
    outcomes: list[Outcome] = [(f.whole if sensor else f.no_sensor)[method] for f in findings]
    return Sample(
        method=method,
        sensor=sensor,
        simulator=[each.case.simulator for each in findings],
        law=[each.law for each in findings],
        natural_hz=np.array([each.natural_hz for each in findings]),
        error_nm=np.array([each.error_nm for each in outcomes]),
        u_nm=np.array([each.u_nm for each in outcomes]),
        expanded_nm=np.array([each.expanded_nm for each in outcomes]),
        mean_error_nm=np.array([each.mean_error_nm for each in outcomes]),
        mean_expanded_nm=np.array([each.mean_expanded_nm for each in outcomes]),
    )


def _rows(sample: Sample) -> Iterable[Row]:
    names = np.array(sample.simulator)
    yield _row(sample, BOTH, np.ones(len(names), bool))
    yield from (_row(sample, each, names == each) for each in RANGES if each in names)


def _laws(sample: Sample) -> Iterable[Row]:
    pairs = np.array([f"{s}: {law}" for s, law in zip(sample.simulator, sample.law, strict=True)])
    wanted = [f"{simulator}: {law}" for simulator, laws in LAWS.items() for law in laws]
    yield from (_row(sample, each, pairs == each) for each in wanted if each in pairs)


def _row(sample: Sample, name: str, of: Array) -> Row:
    error = sample.error_nm[of]
    mean_held = np.abs(sample.mean_error_nm[of]) <= sample.mean_expanded_nm[of]
    return Row(
        method=sample.method,
        simulator=name,
        sensor=sample.sensor,
        rigs=len(error),
        error=_spread(error),
        held=clustered(sample.held[of]),
        mean_held=Share(int(mean_held.sum()), len(mean_held)),
        error_over_u=float(np.sqrt(np.mean((error / sample.u_nm[of]) ** 2))),
    )


def _strata(sample: Sample, band_hz: tuple[float, float]) -> Iterable[Stratum]:
    """Yield one stratum per frequency; of the band's limits the lower belongs to it."""
    low, high = band_hz
    of = (sample.natural_hz >= low) & (sample.natural_hz < high)
    if not of.any():
        return
    for i, frequency in enumerate(FREQUENCIES_HZ):
        held = sample.held[of, i]
        yield Stratum(
            method=sample.method,
            sensor=sample.sensor,
            band_hz=band_hz,
            frequency_hz=frequency,
            held=Share(int(held.sum()), len(held)),
            error=_spread(sample.error_nm[of, i]),
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
