"""Problems that the analyses of a procedure find in its plan, before the rig moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import PluginError
from rigrunner.api.member import Member
from rigrunner.api.planned import PlannedRows, PlannedRun, StationPart
from rigrunner.plan.actions import PlannedRecording
from rigrunner.procedure import Limit
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.devices import Device
    from rigrunner.api.planned import ExpectedReading, PlanProblem
    from rigrunner.plan.actions import Plan
    from rigrunner.procedure import LoadedProcedure, Procedure
    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path


def run_to_come(
    procedure: Procedure, station: LoadedStation, plan: Plan, devices: Mapping[str, Device]
) -> PlannedRun:
    """Return what analyses may know of a run that is planned."""
    drives = (
        Member(role, drive.name)
        for role, device in devices.items()
        for drive in device.drives
        if drive.sets_cycle_frequency
    )
    return PlannedRun(
        rig_keys=station.model.rig,
        instruments=tuple(station.model.instruments),
        recordings=plan.recordings,
        rows=tuple(
            PlannedRows(rows, step.coordinates)
            for step in plan.steps
            if (rows := step.action.rows) is not None
        ),
        devices={
            role: tuple(info.name for info in device.channels) for role, device in devices.items()
        },
        cycle_drive=next(drives, None),
        limits=() if procedure.acceptance is None else procedure.acceptance.limits,
    )


def check_plan(
    procedure: LoadedProcedure, station: LoadedStation, planned: PlannedRun, registry: Registry
) -> None:
    """Raise InvalidFileError with all that analyses say against a plan, each with its place."""
    problems = Problems()
    for path, plugin in procedure.model.analyses_at:
        try:
            plan_problems = registry.plan_problems(plugin.name, plugin.settings, planned)
        except PluginError:
            continue  # reported by the check of the plugins
        for plan_problem in plan_problems:
            _add(problems, plan_problem, path, procedure, station)
    problems.stop_if_any()


def expected_readings(
    procedure: Procedure, planned: PlannedRun, registry: Registry
) -> Iterator[ExpectedReading]:
    """Yield what channels will probably show, as the analyses say; raise PluginError."""
    for _, plugin in procedure.analyses_at:
        yield from registry.expects(plugin.name, plugin.settings, planned)


def _add(
    problems: Problems,
    problem: PlanProblem,
    path: Path,
    procedure: LoadedProcedure,
    station: LoadedStation,
) -> None:
    of, hint = problem.of, problem.hint
    document, at = procedure.document, path
    if isinstance(of, PlannedRecording):
        document, at = of.document, of.path
    elif isinstance(of, Limit):
        limits = procedure.model.acceptance.limits if procedure.model.acceptance else ()
        at = ("acceptance", "limits", next(i for i, limit in enumerate(limits) if limit is of))
    elif isinstance(of, StationPart):
        document, at = station.document, (of.value,)
        where, by = procedure.document.where(path, key=True), problem.needed_by
        if isinstance(by, PlannedRecording):
            where = by.document.where(by.path)
        hint = "; ".join(filter(None, (hint, f"it is needed at {where}")))
    # A problem of the analysis as a whole is placed at its name.
    is_whole = not problem.key and of is None
    problems.add(
        document, (*at, *problem.key), problem.message, hint, key=problem.at_key or is_whole
    )
