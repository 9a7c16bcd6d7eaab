"""The no-load run for a loaded one: found or named, and refused where it does not belong to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, NamedTuple

from rigrunner.analysis.torque.channels import motion_channel
from rigrunner.analysis.torque.one_setup import setup_differences
from rigrunner.analysis.torque.sources import sources
from rigrunner.api.analysis import MotionSource
from rigrunner.api.errors import DataError, RigrunnerError
from rigrunner.api.events import Outcome
from rigrunner.api.instruments import torque_instruments
from rigrunner.api.member import Member
from rigrunner.api.results import REPLAYED
from rigrunner.api.rig import RigDescription
from rigrunner.api.settings import own_keys
from rigrunner.plan.requirements import Point, no_load_problems, points_of_plan, requirers
from rigrunner.plan.selection import analysed
from rigrunner.procedure.analysis_spec import LATEST
from rigrunner.run.locate import find_run, run_names
from rigrunner.run.stored import run_data
from rigrunner.runfile import read, read_info
from rigrunner.station import parse_station

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.devices import Device
    from rigrunner.plan.requirements import Requirer
    from rigrunner.procedure import NoLoadSpec
    from rigrunner.run.prepare import Planned
    from rigrunner.runfile import RunInfo
    from rigrunner.station import Station

JudgeAge = Callable[[timedelta, timedelta, str], Iterator[str]]
"""Yields what speaks against a run's age, given the limit and where that is written."""
FREQUENCY_TOLERANCE = 0.005
"""How far, relatively, a set frequency of the two runs may differ and still be the same one."""
DAYS_FROM = 2.0
"""Ages below are told in hours."""


class NamedNoLoads(NamedTuple):
    """The no-load runs that a person named, by folder or name."""

    before: str | None = None
    after: str | None = None


@dataclass(frozen=True)
class LoadedRun:
    """What of a loaded run decides which no-load run belongs to it."""

    station: Station
    started: datetime
    drive: str
    """The drive that sets the cycle frequency, 'role.drive'."""
    frequencies_hz: Collection[float]
    replays: bool = False
    """Whether it is a replay itself: only then may its no-load run be one."""
    needed: Sequence[Requirer] = ()
    """What the parts of its analysis need of the no-load run."""
    limit_at: str = "max_age"
    """The key that says how old it may be, with file and line."""


def no_load_for(
    planned: Planned, runs: Path, named: str | None = None, started: datetime | None = None
) -> Path | None:
    """Return the no-load run that the planned run needs; None if it needs none; raise DataError.

    The run begins now, unless it has `started` already.
    """
    spec = planned.procedure.model.torque_analysis.no_load
    if spec is None or spec.is_this_run:
        return None
    return find_no_load(spec, _loaded(planned, started or planned.clock.utc()), runs, named)


def no_load_after_for(
    planned: Planned, runs: Path, named: str | None, started: datetime
) -> Path | None:
    """Return the no-load run after one that has `started`: the named, or the first that fits.

    None if the procedure asks for none; raises DataError saying what would fit.
    """
    spec = planned.procedure.model.torque_analysis.no_load
    if spec is None or not spec.after:
        if named is not None:
            raise DataError(
                f"{planned.procedure.model.id} asks for no no-load run after it, and {named} is"
                " named as one",
                hint="write 'after: true' under no_load: in the procedure",
            )
        return None
    return find_no_load_after(spec, _loaded(planned, started), runs, named)


def _loaded(planned: Planned, started: datetime) -> LoadedRun:
    points = points_of_plan(analysed(planned.plan, planned.procedure))
    return LoadedRun(
        station=planned.station.model,
        started=started,
        drive=_cycle_drive(planned.devices),
        frequencies_hz=sorted({point.frequency_hz for point in points if point.frequency_hz > 0}),
        replays=planned.tape is not None and planned.tape.replays,
        needed=requirers(planned.procedure.model, planned.registry),
        limit_at=_where(planned),
    )


def _where(planned: Planned) -> str:
    """Return the key that says how old the no-load run may be, with file and line."""
    model = planned.procedure.model
    at = (*model.torque_analysis_at, "no_load", "max_age")
    return ", ".join(("max_age", str(planned.procedure.document.where(at))))


def find_no_load(spec: NoLoadSpec, loaded: LoadedRun, runs: Path, named: str | None = None) -> Path:
    """Return the named no-load run, or the latest that fits; raise DataError saying what would.

    Only one that began before the loaded run is found by itself; a later one must be named.
    """
    name = named or (None if spec.from_ == LATEST else spec.from_)
    if name is not None:
        path = find_run(name, runs)
        _refuse(path, list(_objections(path, spec, loaded, _named_age)))
        return path
    names = list(reversed(run_names(runs)))
    return _first_fit(names, spec, loaded, runs, _earlier_age)


def find_no_load_after(
    spec: NoLoadSpec, loaded: LoadedRun, runs: Path, named: str | None = None
) -> Path:
    """Return the named no-load run, or the first after the loaded one; raise DataError."""
    if named is None:
        return _first_fit(run_names(runs), spec, loaded, runs, _later_age)
    path = find_run(named, runs)
    _refuse(path, list(_objections(path, spec, loaded, _later_age)))
    return path


def _first_fit(
    names: Iterable[str], spec: NoLoadSpec, loaded: LoadedRun, runs: Path, judge_age: JudgeAge
) -> Path:
    refused: list[str] = []
    for candidate in names:
        objections = list(_objections(runs / candidate, spec, loaded, judge_age))
        if not objections:
            return runs / candidate
        if _is_no_load(runs / candidate, spec):
            refused.append(f"{candidate}: {objections[0]}")
    raise _none_found(spec, loaded, runs, refused)


def _objections(
    path: Path, spec: NoLoadSpec, loaded: LoadedRun, judge_age: JudgeAge
) -> Iterator[str]:
    """Yield why a run cannot serve, in words; the cheap questions first."""
    try:
        info = read_info(path)
        first = next(_formal_objections(info, spec, loaded, judge_age), None)
        yield from (_lacks(path, loaded) if first is None else (first,))
    except RigrunnerError as error:
        yield str(error)


def _formal_objections(
    info: RunInfo, spec: NoLoadSpec, loaded: LoadedRun, judge_age: JudgeAge
) -> Iterator[str]:
    header = info.header
    if header.procedure_id != spec.procedure:
        yield f"it is a run of {header.procedure_id}, not of {spec.procedure}"
    if info.outcome != Outcome.COMPLETED:
        yield f"it was not completed ({info.outcome})"
    if REPLAYED in header.provenance and not loaded.replays:
        yield "it is the replay of a tape"
    yield from _differences(
        parse_station(header.station_text, header.station_id, stored=True).model, spec, loaded
    )
    age, limit = loaded.started - datetime.fromisoformat(header.started_utc), _max_age(spec)
    yield from judge_age(age, limit, loaded.limit_at)


def _too_old(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    if age > limit:
        yield f"it is {_long(age)} old, but at most {_long(limit)} is allowed ({at})"


def _named_age(age: timedelta, limit: timedelta, at: str) -> Iterator[str]:
    yield from _too_old(age, limit, at)
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


def _differences(station: Station, spec: NoLoadSpec, loaded: LoadedRun) -> Iterator[str]:
    pairs = {
        "station": (station.id, loaded.station.id),
        "mandrel": (_rig(station).mandrel, _rig(loaded.station).mandrel),
    }
    for what in spec.same:
        theirs, ours = pairs[what]
        if theirs != ours:
            yield f"its {what} is '{theirs}', but '{ours}' is needed"
    ours_by_channel = torque_instruments(loaded.station.instruments)
    transducers = torque_instruments(station.instruments).values()
    yield from setup_differences(_rig(station), transducers, _rig(loaded.station), ours_by_channel)


def _rig(station: Station) -> RigDescription:
    return own_keys(RigDescription, station.rig)


def _lacks(path: Path, loaded: LoadedRun) -> Iterator[str]:
    """Yield what the analysis needs and its recordings do not give."""
    found = sources(run_data(read(path)))
    there = [each.setpoints.get(loaded.drive, 0.0) for each in found]
    yield from _missing_frequencies(there, loaded)
    points = [
        Point(hz, loaded=False, shows_phase=motion_channel(each)[0] is not MotionSource.ENTERED)
        for hz, each in zip(there, found, strict=True)
    ]
    yield from (message for _, message, _ in no_load_problems(loaded.needed, points))
    least = max((each.needs.cycles for each in loaded.needed), default=0)
    for hz, each in zip(there, found, strict=True):
        whole = int(each.samples / each.rate_hz * hz) - 1 if each.samples > 1 else least
        if whole < least:
            yield f"its recording {each.name} has {whole} cycles, but {least} are needed"


def _missing_frequencies(there: Sequence[float], loaded: LoadedRun) -> Iterator[str]:
    missing = [
        wanted
        for wanted in loaded.frequencies_hz
        if not any(abs(has - wanted) <= FREQUENCY_TOLERANCE * wanted for has in there)
    ]
    if missing:
        yield f"it has no recording at {', '.join(f'{hz:g} Hz' for hz in missing)}"


def _refuse(path: Path, objections: list[str]) -> None:
    if objections:
        raise DataError(
            f"{path} cannot serve as the no-load run: {objections[0]}",
            hint="name another with --no-load, or run the no-load procedure on this rig",
        )


def _is_no_load(path: Path, spec: NoLoadSpec) -> bool:
    """Say whether it is a run of the no-load procedure; by its folder's name if unreadable."""
    try:
        return read_info(path).header.procedure_id == spec.procedure
    except RigrunnerError:
        return bool(spec.procedure) and str(spec.procedure) in path.name


def _none_found(spec: NoLoadSpec, loaded: LoadedRun, runs: Path, refused: list[str]) -> DataError:
    same = {"station": loaded.station.id, "mandrel": _rig(loaded.station).mandrel}
    needed = ", ".join(f"{what} '{same[what]}'" for what in spec.same)
    age = _long(_max_age(spec))
    seen = f"; looked at and refused: {'; '.join(refused)}" if refused else ""
    return DataError(
        f"there is no no-load run in {runs}{seen}",
        hint=f"needed: a completed run of {spec.procedure}, {needed}, at most {age} old; "
        "run that procedure first, or name a run with --no-load",
    )


def _max_age(spec: NoLoadSpec) -> timedelta:
    return timedelta(seconds=spec.max_age)


def _long(age: timedelta) -> str:
    days = age / timedelta(days=1)
    return f"{days:.3g} d" if days >= DAYS_FROM else f"{24 * days:.3g} h"


def _cycle_drive(devices: Mapping[str, Device]) -> str:
    """Return the drive that sets the cycle frequency; '' where there is none."""
    names = (
        Member(role, drive.name)
        for role, device in devices.items()
        for drive in device.drives
        if drive.sets_cycle_frequency
    )
    return next(names, "")
