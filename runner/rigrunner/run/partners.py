"""Partner runs of a run: found or named, and refused if they do not fit."""

from __future__ import annotations

from datetime import datetime, timedelta
from itertools import groupby
from math import isclose
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from pydantic import ValidationError

from rigrunner.api.analysis.requirements import LATEST, STATION
from rigrunner.api.errors import (
    DataError,
    InvalidFileError,
    Problem,
    RigrunnerError,
    UsageError,
)
from rigrunner.api.events import Outcome
from rigrunner.api.results import REPLAYED
from rigrunner.api.settings import own_keys
from rigrunner.plan.partners import asked_runs, in_si
from rigrunner.run.locate import find_run, run_names
from rigrunner.run.stored import run_data
from rigrunner.runfile import read, read_info
from rigrunner.station import parse_station
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rigrunner.api.analysis.requirements import NeededRun
    from rigrunner.api.data import Measurement, Recording, RunData
    from rigrunner.api.errors import Location
    from rigrunner.plan.partners import AskedRun, Value
    from rigrunner.run.prepare import Planned
    from rigrunner.runfile import RunInfo
    from rigrunner.station import Station

    JudgeAge = Callable[[timedelta, timedelta, str], Iterator[str]]
    """Yields problems with the age of a run, given the limit and its place."""

_DAYS_FROM = 2.0
"""Ages up to this are shown in hours."""
_NONE: Mapping[str, str] = MappingProxyType({})


class Required(NamedTuple):
    """A partner run that a planned run requires, and the analyses that require it."""

    planned: Planned
    started: datetime
    asked_runs: tuple[AskedRun, ...]
    """By analysis; all require the same run."""

    @property
    def needed(self) -> NeededRun:
        """Requirements of the run, except what must be measured in it."""
        return self.asked_runs[0].needed

    @property
    def place(self) -> Location:
        """Its place in the procedure."""
        return self.planned.procedure.document.where(self.asked_runs[0].path, key=True)

    @property
    def limit_at(self) -> str:
        """The key of its maximum age, with file and line."""
        path = (*self.asked_runs[0].path, "max_age")
        return ", ".join(("max_age", str(self.planned.procedure.document.where(path))))

    @property
    def max_age(self) -> timedelta:
        """Greatest difference of the start times of both."""
        return timedelta(seconds=self.needed.max_age_s)


def partners_for(
    planned: Planned,
    runs: Path,
    named: Mapping[str, str] = _NONE,
    started: datetime | None = None,
) -> dict[str, Path]:
    """Return the partner runs that a planned run needs before it, by name.

    The named ones, or else the latest that fit. The run begins now, unless it has `started`
    already. Raises DataError with what would fit, UsageError for a name that is not required.
    """
    required_by_name = _required_partners(planned, started or planned.clock.utc())
    _refuse_unrequired(planned, named, required_by_name)
    return {
        name: _find(required, runs, named.get(name))
        for name, required in required_by_name.items()
        if not required.needed.after
    }


def each_partner(
    planned: Planned, runs: Path, named: Mapping[str, str] = _NONE
) -> Iterator[tuple[str, Path | RigrunnerError]]:
    """Yield each partner run before a planned run: its name, and the run or why there is none."""
    for name, required in _required_partners(planned, planned.clock.utc()).items():
        if not required.needed.after:
            try:
                yield name, _find(required, runs, named.get(name))
            except RigrunnerError as error:
                yield name, error


def require_partners(planned: Planned, runs: Path) -> dict[str, Path]:
    """Return the partner runs of a planned run that begins now, by name.

    Raises InvalidFileError with file, line and field of each missing one. Without a folder of runs
    nothing is searched.
    """
    problems, paths = [], {}
    required_by_name = _required_partners(planned, planned.clock.utc()) if runs.is_dir() else {}
    for name, run in each_partner(planned, runs) if required_by_name else ():
        if isinstance(run, Path):
            paths[name] = run
        else:
            field = dotted(required_by_name[name].asked_runs[0].path)
            problems.append(Problem(run.message, required_by_name[name].place, field, run.hint))
    if problems:
        raise InvalidFileError(problems)
    return paths


def partners_after_for(
    planned: Planned, runs: Path, named: Mapping[str, str], started: datetime
) -> dict[str, Path]:
    """Return the partner runs after one that has `started`: the named ones, or the first that fit.

    Raises DataError with what would fit, or for a named run that is not required.
    """
    required_by_name = _required_partners(planned, started)
    later = {name: run for name, run in required_by_name.items() if run.needed.after}
    _refuse_unrequired(planned, named, later)
    return {
        name: _checked_named(required, find_run(named[name], runs), _later_age)
        if name in named
        else _first_fit(required, run_names(runs), runs, _later_age)
        for name, required in later.items()
    }


def later_partners(planned: Planned) -> list[str]:
    """Return the names of the partner runs that are made after a run, which waits for them."""
    asked = asked_runs(planned.procedure.model, planned.registry)
    return sorted({asked_run.needed.name for asked_run in asked if asked_run.needed.after})


def _refuse_unrequired(planned: Planned, named: Iterable[str], required: Iterable[str]) -> None:
    for name in named:
        if name not in required:
            raise UsageError(
                f"{planned.procedure.model.id} asks for no partner run '{name}'",
                hint=f"it asks for: {', '.join(required) or 'none'}",
            )


def _required_partners(planned: Planned, started: datetime) -> dict[str, Required]:
    runs = asked_runs(planned.procedure.model, planned.registry, planned.plan)
    by_name = groupby(sorted(runs, key=_name), _name)
    return {name: Required(planned, started, tuple(group)) for name, group in by_name}


def _name(asked_run: AskedRun) -> str:
    return asked_run.needed.name


def _find(required: Required, runs: Path, named: str | None) -> Path:
    """Return the named run, or the latest that fits; later ones must be named."""
    name = named or (None if required.needed.run == LATEST else required.needed.run)
    if name is not None:
        return _checked_named(required, find_run(name, runs), _named_age)
    # Names begin with the time: the latest one comes first.
    return _first_fit(required, reversed(run_names(runs)), runs, _earlier_age)


def _checked_named(required: Required, path: Path, judge_age: JudgeAge) -> Path:
    objection = next(_objections(path, required, judge_age), None)
    if objection is not None:
        raise DataError(
            f"{path} cannot serve as the {required.needed.words}: {objection}",
            location=required.place,
            hint=f"name another with --partner {required.needed.name}=RUN, or run "
            f"{required.needed.procedure or 'its procedure'} on this rig",
        )
    return path


def _first_fit(required: Required, names: Iterable[str], runs: Path, judge_age: JudgeAge) -> Path:
    refusals: list[str] = []
    for candidate in names:
        objection = next(_objections(runs / candidate, required, judge_age), None)
        if objection is None:
            return runs / candidate
        if _is_of_the_procedure(runs / candidate, required.needed):
            refusals.append(f"{candidate}: {objection}")
    needed = required.needed
    conditions = [f"{key.replace('_', ' ')} '{value}'" for key, value in _shared(required).items()]
    common = ", ".join(conditions) or "anywhere"
    refused = f"; looked at and refused: {'; '.join(refusals)}" if refusals else ""
    raise DataError(
        f"there is no {needed.words} in {runs}{refused}",
        location=required.place,
        hint=f"needed: a completed run of {needed.procedure}, {common}, begun within "
        f"{_span(required.max_age)} of this run; run that procedure first, or name a run with "
        f"--partner {needed.name}=RUN",
    )


def _objections(path: Path, required: Required, judge_age: JudgeAge) -> Iterator[str]:
    """Yield why a run does not fit, as text; quick checks first."""
    try:
        info = read_info(path)
        first = next(_formal_objections(info, required, judge_age), None)
        yield from (_data_objections(run_data(read(path)), required) if first is None else (first,))
    except RigrunnerError as error:
        yield str(error)


def _formal_objections(info: RunInfo, required: Required, judge_age: JudgeAge) -> Iterator[str]:
    header, needed, tape = info.header, required.needed, required.planned.tape
    if needed.procedure and header.procedure_id != needed.procedure:
        yield f"it is a run of {header.procedure_id}, not of {needed.procedure}"
    if info.outcome != Outcome.COMPLETED:
        yield f"it was not completed ({info.outcome})"
    if REPLAYED in header.provenance and not (tape is not None and tape.replays):
        yield "it is the replay of a tape"
    station = parse_station(header.station_text, header.station_id, stored=True).model
    for key, ours in _shared(required).items():
        theirs = _station_value(station, key, required.planned)
        if theirs != ours:
            yield f"its {key.replace('_', ' ')} is '{theirs}', but '{ours}' is needed"
    age = required.started - datetime.fromisoformat(header.started_utc)
    yield from judge_age(age, required.max_age, required.limit_at)


def _shared(required: Required) -> dict[str, object]:
    """Return the properties of this run that its partner must share."""
    station = required.planned.station.model
    return {key: _station_value(station, key, required.planned) for key in required.needed.same}


def _station_value(station: Station, key: str, planned: Planned) -> object:
    """Return a property of a station: its id, or a key of its rig."""
    if key == STATION:
        return station.id
    try:
        rig = own_keys(planned.registry.rig_model(), station.rig)
    except ValidationError:  # of an older run: as written
        return station.rig.get(key)
    return getattr(rig, key, None)


def _too_old(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    if age > limit:
        yield f"it is {_span(age)} old, but at most {_span(limit)} is allowed ({at})"


def _named_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    yield from _too_old(age, limit, at)
    # A named run may be a later one too, within the same limit.
    if age < -limit:
        yield f"it was made {_span(-age)} after this run, by their clocks: is one of them wrong?"


def _earlier_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    yield from _too_old(age, limit, at)
    if age < timedelta(0):
        yield f"it was made {_span(-age)} after this run, and 'latest' takes only an earlier one"


def _later_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    if age >= timedelta(0):
        yield f"it was made {_span(age)} before this run, and the second one has to come after it"
    elif -age > limit:
        after, limit_text = _span(-age), _span(limit)
        yield f"it was made {after} after this run, but at most {limit_text} is allowed ({at})"


def _data_objections(partner: RunData, required: Required) -> Iterator[str]:
    """Yield what its recordings and rows lack for the analyses, and their objections to it."""
    measured: list[tuple[Mapping[str, object], Recording | Measurement]] = [
        *((recording.channels, recording) for recording in partner.recordings),
        *((row.values, row) for row in partner.measurements),
    ]
    for asked_run in required.asked_runs:
        channels = [channel.name for channel in asked_run.needed.channels]
        parts = [part for values, part in measured if all(name in values for name in channels)]
        if channels and not parts:
            yield f"it has no {' and '.join(channels)}"
            continue
        for place in asked_run.values:
            values = {name: in_si(value) for name, value in place.items()}
            if not any(_is_at(values, part, asked_run.needed.within) for part in parts):
                where = ", ".join(f"{name} = {value}" for name, value in place.items())
                yield f"it has no {' and '.join(channels) or 'value'} at {where}"
    planned, registry = required.planned, required.planned.registry
    for _, analysis in planned.procedure.model.analyses_at:
        requirements = registry.requires(analysis.kind, analysis.name, analysis.settings)
        if required.needed.name in {needed.name for needed in requirements.partners}:
            run = planned.to_come()
            yield from registry.partner_problems(analysis.name, analysis.settings, run, partner)


def _is_at(place: Mapping[str, Value], part: Recording | Measurement, within: float) -> bool:
    at = {**part.coordinates, **part.setpoints}
    return all(name in at and _agrees(value, at[name], within) for name, value in place.items())


def _agrees(required: Value, measured: float | str, within: float) -> bool:
    if isinstance(required, str) or isinstance(measured, str):
        return required == measured
    # `abs_tol`, as no relative tolerance lets anything agree with 0.
    return isclose(required, measured, rel_tol=within, abs_tol=1e-12)


def _is_of_the_procedure(path: Path, needed: NeededRun) -> bool:
    """Return whether it is a run of the procedure; by the name of its folder if unreadable."""
    try:
        return read_info(path).header.procedure_id == needed.procedure
    except RigrunnerError:
        return bool(needed.procedure) and needed.procedure in path.name


def _span(age: timedelta) -> str:
    days = age / timedelta(days=1)
    return f"{days:.3g} d" if days >= _DAYS_FROM else f"{24 * days:.3g} h"
