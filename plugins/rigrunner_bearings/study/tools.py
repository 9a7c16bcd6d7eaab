"""What every rig of a study is recorded and analysed with: the shipped procedure and station."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.api import TorqueDetails
from rigrunner.procedure import load_procedure
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.station import load_station

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import Check
    from rigrunner.api.results import Result
    from rigrunner.procedure import AnalysisSpec, Measurand
    from rigrunner.registry import Registry
    from rigrunner.station import Station
    from rigrunner_bearings.study.recording import RecordedBench

PROCEDURE, STATION = "starting_torque_1000n", "simulated"
SUPPORT_LIMIT = 0.01
"""Of what the load changes the support's friction by, on a station that has measured it."""


@dataclass(frozen=True, eq=False)
class Tools:
    """Procedure, station and plugins."""

    station: Station
    spec: AnalysisSpec
    measurand: Measurand | None
    registry: Registry

    @property
    def measured_station(self) -> Station:
        """The same station after its support's friction under load was measured.

        The simulated supports do not change under load by more than that, and a study of a method
        is not to be one of what is assumed where nothing was measured.
        """
        known = {"support_load_dependence": f"{SUPPORT_LIMIT!r} 1"}
        return self.station.model_copy(update={"rig": {**self.station.rig, **known}})

    def analysed(self, recorded: RecordedBench, spec: AnalysisSpec) -> Result:
        """Return the result of both runs; raise DataError where `analyse` does."""
        return analyse(
            recorded.whole,
            spec,
            acceptance=None,
            measurand=self.measurand,
            lookup=self.registry,
        )


@lru_cache(maxsize=1)
def tools() -> Tools:
    """Return them, loaded once in a process."""
    procedure = load_procedure(find_procedure(PROCEDURE)).model
    station = load_station(find_station(STATION)).model
    return Tools(station, procedure.torque_analysis, procedure.measurand, load_registry())


def primary_alone(spec: AnalysisSpec) -> AnalysisSpec:
    """Return an analysis by the primary method and no other."""
    primary = tuple(each for each in spec.compensations if each.name == spec.primary)
    return spec.model_copy(update={"compensations": primary})


def checks_of(result: Result) -> Iterator[Check]:
    """Yield the checks of both runs and of all methods."""
    yield from result.checks
    for each in TorqueDetails.of(result).compensations.values():
        yield from each.checks
