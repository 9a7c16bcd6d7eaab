"""From two files to a run that is ready to start; the rig is not touched."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING, TypeVar, cast

from rigrunner.api.devices import DeviceContext, Patience
from rigrunner.api.errors import InvalidFileError, PluginError, Problem
from rigrunner.clock import SimulatedClock
from rigrunner.plan import (
    check_analyses,
    check_partners,
    check_plan,
    check_plugins,
    check_register,
    check_station_plugins,
    expected_readings,
    make_plan,
    predict,
    run_to_come,
)
from rigrunner.procedure import (
    InconsistentProcedureError,
    check_result_limits,
    kinds_of,
    load_procedure,
)
from rigrunner.rig.messages import DeviceMessages
from rigrunner.run.approval import approval_state
from rigrunner.run.lab_plugins import with_lab_plugins
from rigrunner.station import InconsistentStationError, load_station

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.devices import Clock, Device
    from rigrunner.api.planned import ExpectedReading, PlannedRun
    from rigrunner.plan import Plan, Prediction
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.registry import Registry
    from rigrunner.run.approval import ApprovalState
    from rigrunner.station import LoadedStation
    from rigrunner.tape import Tape

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
    """Records the instruments of the run, or replays them."""
    messages: DeviceMessages = field(default_factory=DeviceMessages)
    """Log messages of the drivers."""

    def prediction(self) -> Prediction:
        """Return the expected readings at each set-point, and the disk space of the run."""
        return predict(self.plan, self.expected(), self.station.register)

    def to_come(self) -> PlannedRun:
        """Return what analyses may know of the run."""
        return run_to_come(self.procedure.model, self.station, self.plan, self.devices)

    def expected(self) -> tuple[ExpectedReading, ...]:
        """Return the expected readings of channels, from the analyses."""
        if not self.procedure.model.analysis:
            return ()
        return tuple(expected_readings(self.procedure.model, self.to_come(), self.registry))


def plan_run(
    procedure: Path, station: Path, registry: Registry, clock: Clock, tape: Tape | None = None
) -> Planned:
    """Load and check both files and plan the run; raise InvalidFileError with all problems."""
    return plan_run_in(procedure, station, registry, lambda _station, _registry: clock, tape)


def plan_run_in(
    procedure: Path,
    station: Path,
    registry: Registry,
    time: TimeOf,
    tape: Tape | None = None,
    *,
    time_limits: bool = True,
    text: str | None = None,
) -> Planned:
    """Do the same with the clock that suits the station, reading each file once.

    Without `time_limits` no call of a device times out: for a debugger. `text` replaces the content
    of the file of the procedure.
    """
    problems, station_problems = _Problems(), _Problems()
    loaded_station = station_problems.without(lambda: load_station(station))
    if loaded_station is not None:
        registry = with_lab_plugins(registry, loaded_station, station.parent)
        if station_problems and loaded_station.model.plugins is not None:  # with its units
            station_problems = _Problems()
            loaded_station = station_problems.without(lambda: load_station(station))
    kinds = kinds_of(registry)
    loaded_procedure = problems.without(lambda: load_procedure(procedure, kinds, text=text))
    problems += station_problems
    if loaded_procedure is None or loaded_station is None:
        # Another name: mypy does not narrow a variable inside a lambda.
        if (readable_station := loaded_station) is not None:
            problems.without(lambda: check_station_plugins(readable_station, registry))
        raise InvalidFileError(problems)
    loaded_station = replace(loaded_station, time_limits=time_limits)
    messages = DeviceMessages()
    problems.without(lambda: check_plugins(loaded_procedure, loaded_station, registry))
    broken = [role for role in loaded_station.model.devices if problems.has(("devices", role))]
    clock = SimulatedClock() if broken else time(loaded_station, registry)
    devices, device_problems = _devices(
        loaded_station, registry, clock, station.parent, tape, broken, messages
    )
    problems += device_problems
    missing = [role for role in loaded_station.model.devices if role not in devices]
    plan = problems.without(
        lambda: make_plan(loaded_procedure, loaded_station, devices), except_for=missing
    )
    problems.without(lambda: check_result_limits(loaded_procedure, registry))
    checked_station = problems.without(lambda: check_register(loaded_station, devices))
    checked_station = checked_station or loaded_station
    # A plan lacks the steps of devices that could not be made: what analyses miss follows from it.
    if plan is not None and not missing:
        if loaded_procedure.model.analysis:
            to_come = run_to_come(loaded_procedure.model, checked_station, plan, devices)
            problems.without(
                lambda: check_plan(loaded_procedure, checked_station, to_come, registry)
            )
        problems.without(lambda: check_analyses(loaded_procedure, checked_station, plan, registry))
    if plan is not None:
        problems.without(lambda: check_partners(loaded_procedure, loaded_station, registry))
    approval = problems.without(lambda: approval_state(loaded_procedure))
    if plan is None or approval is None or problems:
        raise InvalidFileError(problems)
    return Planned(
        loaded_procedure,
        loaded_station,
        devices,
        plan,
        registry,
        clock,
        approval,
        tape,
        messages,
    )


def make_devices(
    station: LoadedStation,
    registry: Registry,
    clock: Clock,
    folder: Path,
    tape: Tape | None = None,
    *,
    messages: DeviceMessages | None = None,
) -> dict[str, Device]:
    """Return the devices of the station by role; raise InvalidFileError."""
    messages = DeviceMessages() if messages is None else messages
    devices, problems = _devices(station, registry, clock, folder, tape, (), messages)
    if problems:
        raise InvalidFileError(problems)
    return devices


def _devices(  # noqa: PLR0917  (as `make_devices`, and broken ones)
    station: LoadedStation,
    registry: Registry,
    clock: Clock,
    folder: Path,
    tape: Tape | None,
    broken: Collection[str],
    messages: DeviceMessages,
) -> tuple[dict[str, Device], list[Problem]]:
    """Return the devices that can be made, and problems of the others except broken settings."""
    patience, devices, problems = patience_of(station), {}, _Problems()
    for role in station.model.devices:
        log = messages.log_of(role)
        context = DeviceContext(role, clock, folder, patience=patience, log=log)
        device = (
            None
            if role in broken
            else problems.without(partial(_device, station, registry, context, tape))
        )
        if device is not None:
            devices[role] = device
    return devices, problems


def patience_of(station: LoadedStation) -> Patience:
    """Return the time limits for the devices of the station; under a debugger endless."""
    waiting = station.model.safety.patience
    return Patience(waiting.connect, waiting.answer if station.time_limits else inf)


class _Problems(list[Problem]):
    """Collects problems of several steps to report them together."""

    def without(self, work: Callable[[], _T], except_for: Collection[str] = ()) -> _T | None:
        """Return the result of the work as far as possible; keep its problems.

        Except those of roles whose devices could not be made, which follow from that.
        """
        missing = [re.compile(rf"(?<!\w){re.escape(role)}(?!\w)") for role in except_for]
        try:
            return work()
        except InvalidFileError as error:
            self += [
                problem
                for problem in error.problems
                if problem not in self
                and not any(word.search(f"{problem.field} {problem.message}") for word in missing)
            ]
            if isinstance(error, (InconsistentProcedureError, InconsistentStationError)):
                return cast("_T", error.loaded)
        return None

    def has(self, path: Sequence[str]) -> bool:
        """Return whether there is a problem at a path, or below it."""
        field = ".".join(path)
        return any(f"{problem.field}.".startswith(f"{field}.") for problem in self)


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
