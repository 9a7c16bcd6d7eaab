"""One rig of the study of coverage: recorded, analysed, and compared with the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.torque.headline import compensated_mean
from rigrunner.api import Estimate, RigDescription, TorqueDetails
from rigrunner.api.settings import own_keys
from rigrunner.procedure.analysis_spec import CompensationRef
from rigrunner.signal.coverage import excess_kurtosis, expanded
from rigrunner.signal.uncertainty import combine
from rigrunner_bearings.study.bench import LOAD_N
from rigrunner_bearings.study.case import Case
from rigrunner_bearings.study.coverage_rigs import RANGES, Limits, draw
from rigrunner_bearings.study.recording import record_bench
from rigrunner_bearings.study.tools import tools

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import CompensatedPoint
    from rigrunner_bearings.study.bench import Bench
    from rigrunner_bearings.study.coverage_rigs import Rig

METHODS = ("template_inverse", "model_inverse")


@dataclass(frozen=True)
class Outcome:
    """What one method said of one rig, against the truth; N·m, one value per set-point."""

    error_nm: tuple[float, ...]
    u_nm: tuple[float, ...]
    expanded_nm: tuple[float, ...]
    """The half-width of the 95 % interval."""
    mean_error_nm: float
    """Of the mean over the set-points, the result of the run."""
    mean_expanded_nm: float


@dataclass(frozen=True)
class Finding:
    """What became of one rig; a method that was refused has no outcome."""

    case: Case
    law: str
    natural_hz: float
    whole: dict[str, Outcome]
    """By method, of recordings with all errors."""
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
        whole=_outcomes(rig, rig.bench, sensor=True),
        no_sensor=_outcomes(rig, rig.without_sensor_errors, sensor=False),
    )


@lru_cache(maxsize=1)
def limits() -> Limits:
    """Return what the primary method's budget allows the rig, and the station it describes."""
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
    recorded = record_bench(bench, shared.registry, rig.station)
    methods = tuple(CompensationRef.model_validate(name) for name in METHODS)
    asked = {"compensations": methods, "primary_": METHODS[0], "fits": ()}
    result = shared.analysed(recorded, shared.spec.model_copy(update=asked))
    truths = np.array(recorded.truths_nm) * LOAD_N / bench.load_n
    return {
        name: _outcome([_kept(each, sensor=sensor) for each in found.points], truths)
        for name, found in TorqueDetails.of(result).compensations.items()
        if found.points
    }


def _kept(point: CompensatedPoint, *, sensor: bool) -> CompensatedPoint:
    if sensor:
        return point
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
