"""What each kind of step does."""

from __future__ import annotations

from statistics import fmean
from typing import TYPE_CHECKING, get_args

from rigrunner.api.errors import AbortedError, DataError
from rigrunner.api.events import Answer, Note, Prompt, Samples
from rigrunner.engine.found import NOTHING, Measured, by_role
from rigrunner.engine.moving import naps, ramp, set_drive, wait
from rigrunner.engine.recorded import RecordedStatistics
from rigrunner.engine.scanning import scan
from rigrunner.engine.streams import checked_stream
from rigrunner.plan import actions
from rigrunner.plan.actions import (
    Ask,
    Confirm,
    Measure,
    Ramp,
    Record,
    Scan,
    SetDrive,
    Settle,
    Wait,
    Zero,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import Action

_NAMES: dict[type, str] = {
    **{kind: kind.__name__.lower() for kind in get_args(actions.Action)},
    SetDrive: "set",
}
"""The keyword of each kind of step in the procedure language."""


def action_name(action: Action) -> str:
    """Return the step's keyword in the procedure language."""
    return _NAMES[type(action)]


def perform(path: str, action: Action, session: Session) -> Measured:  # noqa: PLR0911  (a line for each kind)
    """Do one action of the plan; `path` names the step in questions and errors."""
    match action:
        case SetDrive():
            return set_drive(action, session)
        case Measure():
            return _measure(action, session)
        case Record():
            return _record(action, session)
        case Ramp():
            return ramp(action, session)
        case Scan():
            return scan(path, action, session)
        case Zero():
            return _zero(action, session)
        case _:
            _perform_without_finding(path, action, session)
            return NOTHING


def _perform_without_finding(
    path: str, action: Confirm | Ask | actions.Note | Settle | Wait, session: Session
) -> None:
    match action:
        case Confirm():
            _confirm(path, action, session)
        case Ask():
            _ask(path, action, session)
        case actions.Note(text=text):
            session.emit(Note, step=path, text=text)
        case Settle() | Wait():
            wait(action.duration_s, session)


def _confirm(path: str, action: Confirm, session: Session) -> None:
    known = {"step": path, "text": action.text, "picture": action.picture}
    session.emit(Prompt, **known, choices=("yes", "no"))
    with session.rig.person():
        agreed = session.answers.confirm(path, action)
    session.emit(Answer, step=path, text="yes" if agreed else "no", by=session.answers.by)
    if not agreed:
        raise AbortedError(f"{path}: '{action.text}' was answered with no")


def _ask(path: str, action: Ask, session: Session) -> None:
    expected = action.expected
    known = {"step": path, "text": action.text, "picture": action.picture}
    session.emit(Prompt, **known, choices=expected.choices, expected=expected.words)
    with session.rig.person():
        answer = expected.accept(session.answers.ask(path, action))
    session.emit(Answer, step=path, text=answer, by=session.answers.by, into=action.into)


def _zero(action: Zero, session: Session) -> Measured:
    name = action.member
    mean = _stream_means(action.role, (action.channel,), action.duration_s, session)[name]
    if abs(mean) > action.within:
        raise DataError(
            f"{name} reads {mean:.4g} {action.unit} at rest,"
            f" more than the {action.within:g} {action.unit} allowed",
            hint="is the rig at rest and unloaded? if so, adjust the instrument's zero",
        )
    return Measured({name: mean}, {name: action.unit}, {})


def _measure(action: Measure, session: Session) -> Measured:
    devices = by_role(action.channels)
    if len(devices) == 1:
        role, channels = devices[0]
        return Measured(_values(action, role, channels, session), action.units, {})
    values: dict[str, float] = {}
    for role, channels in devices:
        values.update(_values(action, role, channels, session))
    return Measured({name: values[name] for name in action.channels}, action.units, {})


def _values(
    action: Measure, role: str, channels: Sequence[str], session: Session
) -> Mapping[str, float]:
    if not action.duration_s:
        return session.rig.read(role, channels)
    if action.sample_rate_hz is not None:
        return _stream_means(role, channels, action.duration_s, session)
    readings = [session.rig.read(role, channels) for _ in naps(action.duration_s, session)]
    return {name: fmean(reading[name] for reading in readings) for name in readings[0]}


def _stream_means(
    role: str, channels: Sequence[str], duration_s: float, session: Session
) -> dict[str, float]:
    """Return the mean of each channel over a time, by 'role.channel'."""
    totals: dict[str, float] = {}
    count = 0
    for block in checked_stream(session, role, channels, duration_s):
        count += block.samples
        for name, values in block.channels.items():
            totals[name] = totals.get(name, 0.0) + float(values.sum())
    if not count:
        raise DataError(f"{role}: no sample of {', '.join(channels)} came in {duration_s:g} s")
    return {name: total / count for name, total in totals.items()}


def _record(action: Record, session: Session) -> Measured:
    conditions, units = session.rig.conditions(action.role, action.channels)
    statistics = RecordedStatistics(action.statistics)
    for block in checked_stream(session, action.role, action.channels, action.duration_s):
        session.emit(Samples, recording=action.name, block=block)
        statistics.take(block.channels)
    found, found_units = session.rig.stream_conditions(action.role)
    known = {**action.units, **units, **found_units}
    truth = session.rig.truth(action.role)
    return Measured({**conditions, **found}, known, truth, statistics.found())
