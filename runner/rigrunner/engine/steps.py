"""What each kind of step does."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil
from statistics import fmean
from typing import TYPE_CHECKING, Any, get_args

from rigrunner.api.errors import AbortedError, DataError
from rigrunner.api.events import Answer, Note, Prompt, Samples
from rigrunner.engine.streams import checked_stream
from rigrunner.plan import actions
from rigrunner.plan.actions import Ask, Confirm, Measure, Ramp, Record, SetDrive, Settle, Wait, Zero
from rigrunner.yamlfile.names import split_member

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import Action

_NAP_S = 0.1
"""How long a wait goes on before the stop token is looked at again."""
_MOST_RAMP_STEPS = 1000
_NAMES: dict[type, str] = {
    **{kind: kind.__name__.lower() for kind in get_args(actions.Action)},
    SetDrive: "set",
}
"""The keyword of each kind of step in the procedure language."""


_NONE: Mapping[str, Any] = {}


@dataclass(slots=True)  # to make a frozen one, or a tuple with names, takes twice as long
class Measured:
    """What a step found, in SI units by 'role.name', and what a simulator knows of it."""

    values: Mapping[str, float]
    units: Mapping[str, str]
    truth: Mapping[str, float]


NOTHING = Measured(_NONE, _NONE, _NONE)


def action_name(action: Action) -> str:
    """Return the step's keyword in the procedure language."""
    return _NAMES[type(action)]


def perform(path: str, action: Action, session: Session) -> Measured:
    """Do one action of the plan; `path` names the step in questions and errors."""
    match action:
        case SetDrive():
            return _set(action, session)
        case Measure():
            return _measure(action, session)
        case Record():
            return _record(action, session)
        case Ramp():
            return _ramp(action, session)
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
            for _ in _naps(action.duration_s, session):
                pass


def _confirm(path: str, action: Confirm, session: Session) -> None:
    known = {"step": path, "text": action.text, "picture": action.picture}
    session.emit(Prompt, **known, choices=("yes", "no"))
    agreed = session.answers.confirm(path, action)
    session.emit(Answer, step=path, text="yes" if agreed else "no", by=session.answers.by)
    if not agreed:
        raise AbortedError(f"{path}: '{action.text}' was answered with no")


def _ask(path: str, action: Ask, session: Session) -> None:
    expected = action.expected
    known = {"step": path, "text": action.text, "picture": action.picture}
    session.emit(Prompt, **known, choices=expected.choices, expected=expected.words)
    answer = expected.accept(session.answers.ask(path, action))
    session.emit(Answer, step=path, text=answer, by=session.answers.by, into=action.into)


def _zero(action: Zero, session: Session) -> Measured:
    name = f"{action.role}.{action.channel}"
    mean = _stream_means(action.role, (action.channel,), action.duration_s, session)[name]
    if abs(mean) > action.within:
        raise DataError(
            f"{name} reads {mean:.4g} {action.unit} at rest,"
            f" more than the {action.within:g} {action.unit} allowed",
            hint="is the rig at rest and unloaded? if so, adjust the instrument's zero",
        )
    return Measured({name: mean}, {name: action.unit}, _NONE)


def _set(action: SetDrive, session: Session) -> Measured:
    name = f"{action.role}.{action.drive}"
    session.check()
    rate_per_s = session.rig.led_rate_per_s(action.role, action.drive)
    if rate_per_s is None:
        actual = session.set(action.role, action.drive, action.value)
        return Measured({name: actual}, {name: action.unit}, _NONE)
    start = session.rig.standing(action.role, action.drive)
    seconds = abs(action.value - start) / rate_per_s
    return _ramp(
        Ramp(action.role, action.drive, start, action.value, action.unit, seconds), session
    )


def _ramp(action: Ramp, session: Session) -> Measured:
    """Set the drive again and again, so that it stays on the line from start to end."""
    actual = session.set(action.role, action.drive, action.start)
    clock = session.rig.clock
    began_s = clock.monotonic_s()
    steps = min(max(ceil(action.duration_s / _NAP_S), 1), _MOST_RAMP_STEPS)
    for step in range(1, steps + 1):
        share = step / steps
        value = action.start + share * (action.end - action.start)
        actual = session.set(action.role, action.drive, value)
        session.check()
        for _ in _naps(began_s + share * action.duration_s - clock.monotonic_s(), session):
            pass
    name = f"{action.role}.{action.drive}"
    return Measured({name: actual}, {name: action.unit}, _NONE)


def _measure(action: Measure, session: Session) -> Measured:
    by_role = _by_role(action.channels)
    if len(by_role) == 1:
        role, channels = by_role[0]
        return Measured(_values(action, role, channels, session), action.units, _NONE)
    values: dict[str, float] = {}
    for role, channels in by_role:
        values.update(_values(action, role, channels, session))
    return Measured({name: values[name] for name in action.channels}, action.units, _NONE)


@lru_cache
def _by_role(members: tuple[str, ...]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Return the channels of each role: a sweep measures the same ones at every point."""
    by_role: dict[str, list[str]] = {}
    for member in members:
        role, channel = split_member(member)
        by_role.setdefault(role, []).append(channel)
    return tuple((role, tuple(channels)) for role, channels in by_role.items())


def _values(
    action: Measure, role: str, channels: Sequence[str], session: Session
) -> Mapping[str, float]:
    if not action.duration_s:
        return session.rig.read(role, channels)
    if action.sample_rate_hz is not None:
        return _stream_means(role, channels, action.duration_s, session)
    readings = [session.rig.read(role, channels) for _ in _naps(action.duration_s, session)]
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


def _naps(duration_s: float, session: Session) -> Iterator[None]:
    """Yield while a time passes, often enough for the stop token to be looked at."""
    clock = session.rig.clock
    until_s = clock.monotonic_s() + duration_s
    while (left_s := until_s - clock.monotonic_s()) > 0:
        session.check()
        yield
        clock.sleep(min(left_s, _NAP_S))


def _record(action: Record, session: Session) -> Measured:
    conditions, units = session.rig.conditions(action.role, action.channels)
    for block in checked_stream(session, action.role, action.channels, action.duration_s):
        session.emit(Samples, recording=action.name, block=block)
    found, found_units = session.rig.stream_conditions(action.role)
    known = {**action.units, **units, **found_units}
    return Measured({**conditions, **found}, known, session.rig.truth(action.role))
