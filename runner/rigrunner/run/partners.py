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


class Wanted(NamedTuple):
    """A partner run that a planned run requires, and the analyses that require it."""

    planned: Planned
    started: datetime
    asked: tuple[AskedRun, ...]
    """By analysis; all mean one run."""

    @property
    def needed(self) -> NeededRun:
        """Requirements of the run, except what must be measured in it."""
        return self.asked[0].needed

    @property
    def place(self) -> Location:
        """Its place in the procedure."""
        return self.planned.procedure.document.where(self.asked[0].path, key=True)

    @property
    def limit_at(self) -> str:
        """The key of its maximum age, with file and line."""
        path = (*self.asked[0].path, "max_age")
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
    every = _wanted(planned, started or planned.clock.utc())
    _refuse_unasked(planned, named, every)
    return {
        name: _found(wanted, runs, named.get(name))
        for name, wanted in every.items()
        if not wanted.needed.after
    }


def each_partner(
    planned: Planned, runs: Path, named: Mapping[str, str] = _NONE
) -> Iterator[tuple[str, Path | RigrunnerError]]:
    """Yield each partner run before a planned run: its name, and the run or why there is none."""
    for name, wanted in _wanted(planned, planned.clock.utc()).items():
        if not wanted.needed.after:
            try:
                yield name, _found(wanted, runs, named.get(name))
            except RigrunnerError as error:
                yield name, error


def require_partners(planned: Planned, runs: Path) -> dict[str, Path]:
    """Return the partner runs of a planned run that begins now, by name.

    Raises InvalidFileError with file, line and field of each missing one. Without a folder of runs
    nothing is searched.
    """
    problems, found = [], {}
    wanted = _wanted(planned, planned.clock.utc()) if runs.is_dir() else {}
    for name, run in each_partner(planned, runs) if wanted else ():
        if isinstance(run, Path):
            found[name] = run
        else:
            field = dotted(wanted[name].asked[0].path)
            problems.append(Problem(run.message, wanted[name].place, field, run.hint))
    if problems:
        raise InvalidFileError(problems)
    return found


def partners_after_for(
    planned: Planned, runs: Path, named: Mapping[str, str], started: datetime
) -> dict[str, Path]:
    """Return the partner runs after one that has `started`: the named ones, or the first that fit.

    Raises DataError with what would fit, or for a named run that is not required.
    """
    later = {name: each for name, each in _wanted(planned, started).items() if each.needed.after}
    _refuse_unasked(planned, named, later)
    return {
        name: _named(wanted, find_run(named[name], runs), _later_age)
        if name in named
        else _first_fit(wanted, run_names(runs), runs, _later_age)
        for name, wanted in later.items()
    }


def later_partners(planned: Planned) -> list[str]:
    """Return the names of the partner runs that are made after a run, which waits for them."""
    every = asked_runs(planned.procedure.model, planned.registry)
    return sorted({each.needed.name for each in every if each.needed.after})


def _refuse_unasked(planned: Planned, named: Iterable[str], asked: Iterable[str]) -> None:
    for name in named:
        if name not in asked:
            raise UsageError(
                f"{planned.procedure.model.id} asks for no partner run '{name}'",
                hint=f"it asks for: {', '.join(asked) or 'none'}",
            )


def _wanted(planned: Planned, started: datetime) -> dict[str, Wanted]:
    every = asked_runs(planned.procedure.model, planned.registry, planned.plan)
    by_name = groupby(sorted(every, key=_name), _name)
    return {name: Wanted(planned, started, tuple(asked)) for name, asked in by_name}


def _name(asked: AskedRun) -> str:
    return asked.needed.name


def _found(wanted: Wanted, runs: Path, named: str | None) -> Path:
    """Return the named run, or the latest that fits; later ones must be named."""
    name = named or (None if wanted.needed.run == LATEST else wanted.needed.run)
    if name is not None:
        return _named(wanted, find_run(name, runs), _named_age)
    # Names begin with the time: the latest one comes first.
    return _first_fit(wanted, reversed(run_names(runs)), runs, _earlier_age)


def _named(wanted: Wanted, path: Path, judge_age: JudgeAge) -> Path:
    objection = next(_objections(path, wanted, judge_age), None)
    if objection is not None:
        raise DataError(
            f"{path} cannot serve as the {wanted.needed.words}: {objection}",
            location=wanted.place,
            hint=f"name another with --partner {wanted.needed.name}=RUN, or run "
            f"{wanted.needed.procedure or 'its procedure'} on this rig",
        )
    return path


def _first_fit(wanted: Wanted, names: Iterable[str], runs: Path, judge_age: JudgeAge) -> Path:
    refused: list[str] = []
    for candidate in names:
        objection = next(_objections(runs / candidate, wanted, judge_age), None)
        if objection is None:
            return runs / candidate
        if _is_of_the_procedure(runs / candidate, wanted.needed):
            refused.append(f"{candidate}: {objection}")
    needed = wanted.needed
    words = [f"{what.replace('_', ' ')} '{is_}'" for what, is_ in _common(wanted).items()]
    common = ", ".join(words) or "anywhere"
    seen = f"; looked at and refused: {'; '.join(refused)}" if refused else ""
    raise DataError(
        f"there is no {needed.words} in {runs}{seen}",
        location=wanted.place,
        hint=f"needed: a completed run of {needed.procedure}, {common}, begun within "
        f"{_long(wanted.max_age)} of this run; run that procedure first, or name a run with "
        f"--partner {needed.name}=RUN",
    )


def _objections(path: Path, wanted: Wanted, judge_age: JudgeAge) -> Iterator[str]:
    """Yield why a run does not fit, as text; quick checks first."""
    try:
        info = read_info(path)
        first = next(_formal_objections(info, wanted, judge_age), None)
        yield from (_lacks(run_data(read(path)), wanted) if first is None else (first,))
    except RigrunnerError as error:
        yield str(error)


def _formal_objections(info: RunInfo, wanted: Wanted, judge_age: JudgeAge) -> Iterator[str]:
    header, needed, tape = info.header, wanted.needed, wanted.planned.tape
    if needed.procedure and header.procedure_id != needed.procedure:
        yield f"it is a run of {header.procedure_id}, not of {needed.procedure}"
    if info.outcome != Outcome.COMPLETED:
        yield f"it was not completed ({info.outcome})"
    if REPLAYED in header.provenance and not (tape is not None and tape.replays):
        yield "it is the replay of a tape"
    station = parse_station(header.station_text, header.station_id, stored=True).model
    for what, ours in _common(wanted).items():
        theirs = _known(station, what, wanted.planned)
        if theirs != ours:
            yield f"its {what.replace('_', ' ')} is '{theirs}', but '{ours}' is needed"
    age = wanted.started - datetime.fromisoformat(header.started_utc)
    yield from judge_age(age, wanted.max_age, wanted.limit_at)


def _common(wanted: Wanted) -> dict[str, object]:
    """Return what both must share, for this run."""
    station = wanted.planned.station.model
    return {what: _known(station, what, wanted.planned) for what in wanted.needed.same}


def _known(station: Station, what: str, planned: Planned) -> object:
    """Return what is known of a station: its id, or a key of its rig."""
    if what == STATION:
        return station.id
    try:
        rig = own_keys(planned.registry.rig_model(), station.rig)
    except ValidationError:  # of an older run: as it is written
        return station.rig.get(what)
    return getattr(rig, what, None)


def _too_old(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    if age > limit:
        yield f"it is {_long(age)} old, but at most {_long(limit)} is allowed ({at})"


def _named_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    yield from _too_old(age, limit, at)
    # A named run may be a later one too, within the same limit.
    if age < -limit:
        yield f"it was made {_long(-age)} after this run, by their clocks: is one of them wrong?"


def _earlier_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    yield from _too_old(age, limit, at)
    if age < timedelta(0):
        yield f"it was made {_long(-age)} after this run, and 'latest' takes only an earlier one"


def _later_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    if age >= timedelta(0):
        yield f"it was made {_long(age)} before this run, and the second one has to come after it"
    elif -age > limit:
        after, most = _long(-age), _long(limit)
        yield f"it was made {after} after this run, but at most {most} is allowed ({at})"


def _lacks(partner: RunData, wanted: Wanted) -> Iterator[str]:
    """Yield what analyses need and its recordings and rows lack, and what they say against it."""
    measured: list[tuple[Mapping[str, object], Recording | Measurement]] = [
        *((each.channels, each) for each in partner.recordings),
        *((each.values, each) for each in partner.measurements),
    ]
    for asked in wanted.asked:
        channels = [each.name for each in asked.needed.channels]
        there = [each for known, each in measured if all(name in known for name in channels)]
        if channels and not there:
            yield f"it has no {' and '.join(channels)}"
            continue
        for place in asked.values:
            values = {name: in_si(each) for name, each in place.items()}
            if not any(_is_there(values, each, asked.needed.within) for each in there):
                where = ", ".join(f"{name} = {each}" for name, each in place.items())
                yield f"it has no {' and '.join(channels) or 'value'} at {where}"
    planned, registry = wanted.planned, wanted.planned.registry
    for _, each in planned.procedure.model.analyses_at:
        needs = registry.requires(each.kind, each.name, each.settings)
        if wanted.needed.name in {one.name for one in needs.partners}:
            given = planned.to_come()
            yield from registry.partner_problems(each.name, each.settings, given, partner)


def _is_there(wanted: Mapping[str, Value], of: Recording | Measurement, within: float) -> bool:
    known = {**of.coordinates, **of.setpoints}
    return all(name in known and _is(value, known[name], within) for name, value in wanted.items())


def _is(wanted: Value, found: float | str, within: float) -> bool:
    if isinstance(wanted, str) or isinstance(found, str):
        return wanted == found
    # `abs_tol`, as no relative tolerance lets anything agree with 0.
    return isclose(wanted, found, rel_tol=within, abs_tol=1e-12)


def _is_of_the_procedure(path: Path, needed: NeededRun) -> bool:
    """Return whether it is a run of the procedure; by the name of its folder if unreadable."""
    try:
        return read_info(path).header.procedure_id == needed.procedure
    except RigrunnerError:
        return bool(needed.procedure) and needed.procedure in path.name


def _long(age: timedelta) -> str:
    days = age / timedelta(days=1)
    return f"{days:.3g} d" if days >= _DAYS_FROM else f"{24 * days:.3g} h"
