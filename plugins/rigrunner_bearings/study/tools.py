"""The shipped procedure and station, with which every rig of a study is recorded and analysed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from rigrunner.analysis.analyse import analyse
from rigrunner.procedure import AnalysisRef, load_procedure
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.station import load_station
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.torque.settings import SwingTorque

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import Check
    from rigrunner.api.results import Result
    from rigrunner.procedure import Measurand
    from rigrunner.registry import Registry
    from rigrunner.station import Station
    from rigrunner_bearings.study.recording import RecordedBench
    from rigrunner_bearings.torque.settings import TorqueSettings

PROCEDURE, STATION = "starting_torque_1000n", "simulated"
SUPPORT_LIMIT = 0.01
"""Relative change of the support's friction under load, on a station that has measured it."""


@dataclass(frozen=True, eq=False)
class Tools:
    """Procedure, station and plugins."""

    station: Station
    spec: TorqueSettings
    measurand: Measurand | None
    registry: Registry

    @property
    def measured_station(self) -> Station:
        """The station after a measurement of its support's friction under load.

        The simulated supports do not change by more than that, and a study of a method should not
        depend on what is assumed without a measurement.
        """
        measured = {"support_load_dependence": f"{SUPPORT_LIMIT!r} 1"}
        return self.station.model_copy(update={"rig": {**self.station.rig, **measured}})

    def analysed(self, bench_runs: RecordedBench, spec: TorqueSettings) -> Result:
        """Return the result of both runs; raise DataError where `analyse` does."""
        return analyse(
            bench_runs.loaded_with_partners,
            (analysis_ref(spec),),
            acceptance=None,
            measurand=self.measurand,
            lookup=self.registry,
        )


@lru_cache(maxsize=1)
def tools() -> Tools:
    """Return the tools, loaded once in a process."""
    procedure = load_procedure(find_procedure(PROCEDURE)).model
    station = load_station(find_station(STATION)).model
    spec = SwingTorque.model_validate(procedure.analysis[0].settings)
    return Tools(station, spec, procedure.measurand, load_registry())


def analysis_ref(spec: TorqueSettings) -> AnalysisRef:
    """Return the analysis of torque with these settings."""
    name = "swing_torque" if spec.starts is None else "breakaway"
    settings: Any = spec  # validated already
    return AnalysisRef.model_construct(name=name, settings=settings, label=name)


def primary_alone(spec: TorqueSettings) -> TorqueSettings:
    """Return an analysis by the primary method and no other."""
    primary = tuple(method for method in spec.compensations if method.label == spec.primary)
    return spec.model_copy(update={"compensations": primary})


def checks_of(result: Result) -> Iterator[Check]:
    """Yield the checks of both runs and of all methods."""
    yield from result.checks
    for compensation in TorqueDetails.of(result).compensations.values():
        yield from compensation.checks
