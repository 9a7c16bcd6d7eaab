"""Whether a run will give the analysis what it requires, asked before the rig moves.

The analysis itself, the rule for gross errors, the primary compensation and the fit that it takes
each say what they need, as `Requirements`. Another compensation than the primary one may turn out
to be not applicable: the run has its result all the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.analysis.requirements import (
    LEAST_CYCLES,
    LEAST_CYCLES_WITH_RULE,
    LEAST_REST_S,
    LEAST_SAMPLES_PER_CYCLE,
    LEAST_STARTS,
    SPARE_CYCLES,
    Requirements,
)
from rigrunner.api.errors import PluginError
from rigrunner.api.member import Member
from rigrunner.plan.needs import TORQUE, channels_of, motion_channels
from rigrunner.plan.selection import analysed
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.plan.actions import Plan, Recorded
    from rigrunner.procedure import AnalysisSpec, LoadedProcedure, Procedure
    from rigrunner.yamlfile.document import Path

_ROUNDING = 1e-9


class RequirementsLookup(Protocol):
    """Knows what each plugin of the analysis needs."""

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return what a plugin needs with these settings; raise PluginError."""
        ...

    def rejects(self, rule: str) -> bool:
        """Say whether an outlier rule can reject anything; raise PluginError."""
        ...


@dataclass(frozen=True)
class Requirer:
    """A part of the analysis with what it needs."""

    name: str
    """In words, such as "the compensation 'energy'"."""
    path: Path
    """Where the procedure names it."""
    needs: Requirements


@dataclass(frozen=True)
class Point:
    """What a recording, or a row of a table, will give the analysis."""

    frequency_hz: float
    loaded: bool
    shows_phase: bool
    """Whether a recorded channel shows the crank phase."""


def requirers(procedure: Procedure, lookup: RequirementsLookup) -> tuple[Requirer, ...]:
    """Return all parts of an analysis that a run cannot do without; raise PluginError."""
    spec, at = procedure.torque_analysis, procedure.torque_analysis_at
    found = [_analysis(spec, at, lookup)]
    if spec.outliers is not None:
        rule = spec.outliers
        needs = lookup.requires("outlier_rule", rule.name, rule.settings)
        found.append(Requirer(f"the rule '{rule.name}'", (*at, "outliers"), needs))
    primary = spec.primary_plugin
    if primary is not None:
        needs = lookup.requires("compensation", primary.name, primary.settings)
        index = spec.compensations.index(primary)
        path: Path = (*at, "compensations", index)
        found.append(Requirer(f"the compensation '{primary.label}'", path, needs))
        if needs.fit and spec.fits:
            fit = spec.fits[0]
            of_fit = lookup.requires("fit", fit.name, fit.settings)
            found.append(Requirer(f"the fit '{fit.label}'", (*at, "fits", 0), of_fit))
    return tuple(found)


def no_load_problems(
    needed: Iterable[Requirer], no_load: Sequence[Point]
) -> Iterator[tuple[Requirer, str, str]]:
    """Yield who needs more than the set-points without load give, in words, and a way out."""
    frequencies = sorted({point.frequency_hz for point in no_load})
    for each in needed:
        least = each.needs.points
        if len(frequencies) < least:
            got = ", ".join(f"{hz:g} Hz" for hz in frequencies) or "none"
            message = f"{each.name} needs {least} different frequencies without load, got {got}"
            yield each, message, "record without load at more frequencies"
        if each.needs.phase and not all(point.shows_phase for point in no_load):
            message = f"{each.name} needs the crank phase, and without load nothing shows it"
            yield each, message, "record the angle without load, such as tester.angle"


def check_requirements(procedure: LoadedProcedure, plan: Plan, lookup: RequirementsLookup) -> None:
    """Raise InvalidFileError with all that the analysis needs and the run would not give.

    What a no-load run of its own must have is asked when that run is chosen.
    """
    spec = procedure.model.torque_analysis
    if len(procedure.model.named_analyses) == len(procedure.model.analysis):
        return
    problems, plan = Problems(), analysed(plan, procedure)
    if not (spec.fits or spec.compensations):
        message = "the analysis names neither a fit nor a compensation, so it has no result"
        hint = "add 'fits: [polynomial]', or leave 'analysis' out to record only"
        at = procedure.model.torque_analysis_at
        problems.add(procedure.document, at, message, hint, key=True)
        problems.stop_if_any()
    try:
        needed = requirers(procedure.model, lookup)
    except PluginError:
        return  # told by the check of the plugins
    _check_kind(procedure, needed, problems)
    if plan.recordings:
        _check_recordings(procedure, plan, needed, problems)
    else:
        _check_tables(procedure, plan, needed, problems)
    problems.stop_if_any()


def points_of_plan(plan: Plan) -> list[Point]:
    """Return the points of a plan: its recordings, or else the rows of its tables with a torque."""
    if plan.recordings:
        return [_point(each) for each in plan.recordings]
    return list(_rows(plan))


def _analysis(spec: AnalysisSpec, at: Path, lookup: RequirementsLookup) -> Requirer:
    """Return what is needed whatever plugins there are; a rule may reject half of the cycles."""
    name = "the analysis"
    if spec.starts is not None:
        return Requirer(name, at, Requirements(cycles=LEAST_STARTS))
    if spec.outliers is not None and lookup.rejects(spec.outliers.name):
        name += f", with the rule '{spec.outliers.name}',"
        least = LEAST_CYCLES_WITH_RULE - SPARE_CYCLES
        return Requirer(name, at, Requirements(cycles=least))
    return Requirer(name, at, Requirements(cycles=LEAST_CYCLES))


def _check_kind(procedure: LoadedProcedure, needed: Iterable[Requirer], problems: Problems) -> None:
    spec = procedure.model.torque_analysis
    for each in needed:
        if each.needs.fit and not spec.fits:
            message = f"{each.name} takes the first fit, and the procedure names none"
            hint = "add one to the analysis, such as 'fits: [polynomial]'"
            problems.add(procedure.document, each.path, message, hint)
        if each.needs.starts is True and spec.starts is None:
            message = f"{each.name} needs starts from rest, and these are swings"
            hint = "write 'breakaway' in the place of 'swing_torque' if they are starts"
            problems.add(procedure.document, each.path, message, hint)
        if each.needs.starts is False and spec.starts is not None:
            message = f"{each.name} needs swings, and these are starts from rest"
            hint = "choose a compensation for starts, such as breakaway_peak"
            problems.add(procedure.document, each.path, message, hint)


def _check_recordings(
    procedure: LoadedProcedure, plan: Plan, needed: Sequence[Requirer], problems: Problems
) -> None:
    spec = procedure.model.torque_analysis
    if spec.starts is not None:
        _check_starts(procedure, plan, needed, problems)
        return
    for recorded in plan.recordings:
        _check_load(recorded, problems)
        check_cycles(recorded, needed, problems)
        _check_rate(recorded, problems)
        _check_phase(recorded, needed, problems)
    _check_own_no_load(procedure, points_of_plan(plan), needed, problems)


def check_cycles(recorded: Recorded, needed: Iterable[Requirer], problems: Problems) -> None:
    """Ask for enough whole cycles: a recording is of one period more than it has whole ones."""
    record = recorded.record
    frequency_hz = record.cycle_frequency_hz or 0.0
    whole = int(record.duration_s * frequency_hz + _ROUNDING) - 1
    most = max(needed, key=lambda each: each.needs.cycles)
    least = most.needs.cycles + SPARE_CYCLES
    if whole >= least:
        return
    asked_for = "cycles" if recorded.document.part((*recorded.path, "cycles")) else "duration"
    at = f"{max(whole, 0)} at {frequency_hz:g} Hz" if asked_for == "duration" else str(whole)
    message = f"{most.name} needs at least {least} cycles in each recording, got {at}"
    hint = f"{most.needs.cycles} whole ones are needed, and a spare one"
    problems.add(recorded.document, (*recorded.path, asked_for), message, hint)


def _check_rate(recorded: Recorded, problems: Problems) -> None:
    rate_hz, frequency_hz = recorded.record.sample_rate_hz, recorded.record.cycle_frequency_hz
    if rate_hz is None or not frequency_hz or rate_hz >= LEAST_SAMPLES_PER_CYCLE * frequency_hz:
        return
    message = (
        f"the analysis needs at least {LEAST_SAMPLES_PER_CYCLE} samples in a cycle, "
        f"got {rate_hz / frequency_hz:.3g}: {rate_hz:g} Hz at {frequency_hz:g} Hz"
    )
    hint = "sample faster, or swing more slowly"
    problems.add(recorded.document, recorded.path, message, hint, key=True)


def _check_phase(recorded: Recorded, needed: Iterable[Requirer], problems: Problems) -> None:
    if motion_channels(recorded.record):
        return
    for each in needed:
        if each.needs.phase:
            message = f"{each.name} needs the crank phase, and no recorded channel shows it"
            hint = f"record an angle, such as {recorded.record.role}.angle"
            problems.add(recorded.document, (*recorded.path, "channels"), message, hint)


def _check_load(recorded: Recorded, problems: Problems) -> None:
    """Ask for a known load: each point of a result is one under a load."""
    member = Member(recorded.record.role, "load")
    if member not in recorded.record.setpoints and member not in recorded.conditions:
        message = f"the analysis needs the load, and {member} is neither set nor read"
        hint = f"set it before, such as 'set: {{{member}: 0 N}}'"
        problems.add(recorded.document, recorded.path, message, hint, key=True)


def _check_starts(
    procedure: LoadedProcedure, plan: Plan, needed: Sequence[Requirer], problems: Problems
) -> None:
    spec = procedure.model.torque_analysis
    window = spec.starts.window if spec.starts else 0.0
    groups: dict[tuple[float, float], list[Recorded]] = {}
    for recorded in plan.recordings:
        speed_hz, load_n = _place_of_start(recorded)
        groups.setdefault((speed_hz, load_n), []).append(recorded)
        _check_travel(recorded, speed_hz, window, problems)
    most = max(needed, key=lambda each: each.needs.cycles)
    for (speed_hz, load_n), group in groups.items():
        if len(group) < most.needs.cycles:
            message = (
                f"{most.name} needs at least {most.needs.cycles} starts at each speed and load, "
                f"got {len(group)} at {speed_hz:g} Hz and {load_n:g} N"
            )
            hint = "repeat the recording"
            problems.add(group[0].document, group[0].path, message, hint, key=True)


def _place_of_start(recorded: Recorded) -> tuple[float, float]:
    role, setpoints = recorded.record.role, recorded.record.setpoints
    speed_hz = setpoints.get(
        Member(role, "start_frequency"), setpoints.get(Member(role, "frequency"), 0.0)
    )
    return speed_hz, setpoints.get(Member(role, "load"), 0.0)


def _check_travel(
    recorded: Recorded, speed_hz: float, window_rad: float, problems: Problems
) -> None:
    """Ask for an angle, and for time enough to rest and to turn through the window."""
    record = recorded.record
    if not channels_of(record, "angle"):
        message = "a start from rest needs an angle, and none is recorded"
        hint = f"record the angle of rotation, such as {record.role}.angle"
        problems.add(recorded.document, (*recorded.path, "channels"), message, hint)
    if not speed_hz > 0:
        message = "the analysis needs a start, and no speed is set here"
        problems.add(recorded.document, recorded.path, message, "set the drive before", key=True)
        return
    least_s = LEAST_REST_S + window_rad / (2 * pi * speed_hz)
    if record.duration_s <= least_s:
        message = (
            f"a start at {speed_hz:g} Hz needs more than {least_s:.3g} s, "
            f"got {record.duration_s:.3g} s"
        )
        hint = f"{LEAST_REST_S:g} s of rest, and the time to turn through the window"
        problems.add(recorded.document, (*recorded.path, "duration"), message, hint)


def _check_own_no_load(
    procedure: LoadedProcedure,
    points: Sequence[Point],
    needed: Sequence[Requirer],
    problems: Problems,
) -> None:
    """Ask of a run that is its own no-load run for both kinds of set-points, at fitting places."""
    no_load_spec = procedure.model.torque_analysis.no_load
    if no_load_spec is None or not no_load_spec.is_this_run:
        return
    document, at = procedure.document, (*procedure.model.torque_analysis_at, "no_load")
    loaded = [point for point in points if point.loaded]
    no_load = [point for point in points if not point.loaded]
    for kind, found in (("with", loaded), ("without", no_load)):
        if not found:
            message = f"the run is to be its own no-load run, and has no set-point {kind} load"
            problems.add(document, at, message, "set the load to 0 N for one part of the run")
    if not (loaded and no_load):
        return
    for each, message, hint in no_load_problems(needed, no_load):
        problems.add(document, each.path, message, hint)
    for each in needed:
        missing = unmatched(each.needs, loaded, no_load)
        if missing:
            hint = f"without load: {', '.join(f'{p.frequency_hz:g} Hz' for p in no_load)}"
            message = f"{each.name} needs set-points without load for {missing}"
            problems.add(document, each.path, message, hint)


def unmatched(needs: Requirements, loaded: Iterable[Point], no_load: Iterable[Point]) -> str:
    """Return the loaded frequencies for which those without load do not do; '' for none."""
    there = [point.frequency_hz for point in no_load]
    missing = [
        hz
        for hz in dict.fromkeys(point.frequency_hz for point in loaded)
        if (
            needs.frequency_match is not None
            and not any(abs(other - hz) <= needs.frequency_match * hz for other in there)
        )
        or (needs.within_no_load_range and not min(there) <= hz <= max(there))
    ]
    return ", ".join(f"{hz:g} Hz" for hz in missing)


def _check_tables(
    procedure: LoadedProcedure, plan: Plan, needed: Sequence[Requirer], problems: Problems
) -> None:
    """Ask of a run without recordings for a torque that is measured in motion, and a load."""
    points = list(_rows(plan))
    document = procedure.document
    if not points:
        message = "the analysis needs a recording, or a torque that is measured in motion"
        hint = "add a record step, or set the frequency before the torque is measured"
        problems.add(document, procedure.model.torque_analysis_at, message, hint, key=True)
        return
    if procedure.model.torque_analysis.starts is not None:
        message = "starts from rest need recordings, and only single values are measured"
        at = procedure.model.torque_analysis_at
        problems.add(document, at, message, "add a record step", key=True)
    for each in needed:
        if each.needs.phase:
            message = f"{each.name} needs recorded swings, and only single values are measured"
            problems.add(document, each.path, message, "record the angle and the torque")
    _check_own_no_load(procedure, points, needed, problems)


def _point(recorded: Recorded) -> Point:
    record = recorded.record
    return Point(
        frequency_hz=record.cycle_frequency_hz or 0.0,
        loaded=record.setpoints.get(Member(record.role, "load"), 0.0) > 0,
        shows_phase=bool(motion_channels(record)),
    )


def _rows(plan: Plan) -> Iterator[Point]:
    """Yield the rows of tables that have a torque, in motion."""
    for step in plan.steps:
        rows = step.action.rows
        if rows is None:
            continue
        roles = {each.role for each in rows.channels if rows.units.get(each) == TORQUE}
        for setpoints in rows.setpoints:
            for role in roles:
                frequency_hz = setpoints.get(Member(role, "frequency"), 0.0)
                if frequency_hz > 0:
                    loaded = setpoints.get(Member(role, "load"), 0.0) > 0
                    yield Point(frequency_hz, loaded, shows_phase=False)
