"""From two files to a run that is ready to start: nothing of the rig is touched yet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar, cast

from rigrunner.api.devices import DeviceContext, Patience
from rigrunner.api.errors import InvalidFileError, PluginError, Problem
from rigrunner.plan import check_limits, check_plugins, make_plan, predict
from rigrunner.procedure import InconsistentProcedureError, load_procedure
from rigrunner.station import load_station
from rigrunner.workflow.approval import approval_state
from rigrunner.workflow.lab_plugins import with_lab_plugins

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from rigrunner.api.devices import Clock, Device
    from rigrunner.plan import Plan, Prediction
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation
    from rigrunner.tape import Tape
    from rigrunner.workflow.approval import ApprovalState

    TimeOf = Callable[[LoadedStation, Registry], Clock]

_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Planned:
    """A procedure on a station, checked in every way that needs no rig."""

    procedure: LoadedProcedure
    station: LoadedStation
    devices: Mapping[str, Device]
    plan: Plan
    registry: Registry
    clock: Clock
    approval: ApprovalState
    tape: Tape | None = None
    """What records the run's instruments, or plays them back."""

    def prediction(self) -> Prediction:
        """Return what torque is to be expected where, and how much disk the run takes."""
        return predict(self.procedure, self.station, self.plan)


def plan_run(
    procedure: Path, station: Path, registry: Registry, clock: Clock, tape: Tape | None = None
) -> Planned:
    """Load and check both files and plan the run; raise InvalidFileError with all problems."""
    return plan_run_in(procedure, station, registry, lambda _station, _registry: clock, tape)


def plan_run_in(
    procedure: Path, station: Path, registry: Registry, time: TimeOf, tape: Tape | None = None
) -> Planned:
    """Do the same in the time that suits the station, each file read once."""
    problems = _Problems()
    loaded_procedure = problems.without(lambda: load_procedure(procedure))
    loaded_station = problems.without(lambda: load_station(station))
    if loaded_procedure is None or loaded_station is None:
        raise InvalidFileError(problems)
    registry = with_lab_plugins(registry, loaded_station, station.parent)
    problems.without(lambda: check_plugins(loaded_procedure, loaded_station, registry))
    if any(problem.field.startswith("devices") for problem in problems):
        raise InvalidFileError(problems)
    clock = time(loaded_station, registry)
    devices = make_devices(loaded_station, registry, clock, station.parent, tape)
    plan = problems.without(lambda: make_plan(loaded_procedure, loaded_station, devices))
    problems.without(lambda: check_limits(loaded_procedure, plan, registry))
    approval = problems.without(lambda: approval_state(loaded_procedure))
    if plan is None or approval is None or problems:
        raise InvalidFileError(problems)
    return Planned(loaded_procedure, loaded_station, devices, plan, registry, clock, approval, tape)


def make_devices(
    station: LoadedStation, registry: Registry, clock: Clock, folder: Path, tape: Tape | None = None
) -> dict[str, Device]:
    """Return the devices of the station in that folder by role; raise InvalidFileError."""
    patience = patience_of(station)
    return {
        role: _device(
            station, registry, DeviceContext(role, clock, folder, patience=patience), tape
        )
        for role in station.model.devices
    }


def patience_of(station: LoadedStation) -> Patience:
    """Return how long the station's devices are waited for."""
    waiting = station.model.safety.patience
    return Patience(waiting.connect, waiting.answer)


class _Problems(list[Problem]):
    """What is wrong, gathered over several steps so that it can be told at once."""

    def without(self, work: Callable[[], _T]) -> _T | None:
        """Return what the work gives, as far as it can be had; keep its problems."""
        try:
            return work()
        except InvalidFileError as error:
            self += [problem for problem in error.problems if problem not in self]
            if isinstance(error, InconsistentProcedureError):
                return cast("_T", error.loaded)
        return None


def _device(
    station: LoadedStation, registry: Registry, context: DeviceContext, tape: Tape | None
) -> Device:
    entry = station.model.devices[context.role]
    try:
        return registry.make_device(entry.plugin, entry.settings, context, tape)
    except PluginError as error:
        path = ("devices", context.role, "settings")
        where = station.document.where(path)
        raise InvalidFileError(
            [Problem(error.message, where, ".".join(path), error.hint)]
        ) from error
