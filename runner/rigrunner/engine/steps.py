"""What each kind of step does."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import fmean
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.errors import AbortedError, DataError
from rigrunner.api.events import Answer, Prompt, Samples
from rigrunner.engine.streams import check_stop, checked_stream
from rigrunner.plan.actions import Ask, Confirm, Measure, Record, SetDrive, Settle, Zero
from rigrunner.yamlfile.names import split_member

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.devices import StopToken
    from rigrunner.api.events import Event
    from rigrunner.engine.answers import AnswerSource
    from rigrunner.plan.actions import Action
    from rigrunner.rig import Rig

_NAP_S = 0.1
"""How long a wait goes on before the stop token is looked at again."""


class Emit(Protocol):
    """Puts an event on the bus."""

    def __call__(self, kind: type[Event], **fields: Any) -> None:
        """Stamp and hand out an event of that kind."""
        ...


@dataclass(frozen=True)
class Session:
    """What steps work with."""

    rig: Rig
    emit: Emit
    answers: AnswerSource
    stop: StopToken


@dataclass(frozen=True)
class Measured:
    """What a step found, in SI units by 'role.name', and what a simulator knows of it."""

    values: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    truth: Mapping[str, float] = field(default_factory=dict)


def action_name(action: Action) -> str:
    """Return the step's keyword in the procedure language."""
    return "set" if isinstance(action, SetDrive) else type(action).__name__.lower()


def perform(path: str, action: Action, session: Session) -> Measured:  # noqa: PLR0911  (one for each kind)
    """Do one action of the plan; `path` names the step in questions and errors."""
    match action:
        case Confirm():
            return _confirm(path, action, session)
        case Ask():
            return _ask(path, action, session)
        case Zero():
            return _zero(action, session)
        case SetDrive():
            return _set(action, session)
        case Settle():
            return _settle(action, session)
        case Record():
            return _record(action, session)
        case Measure():
            return _measure(action, session)


def _confirm(path: str, action: Confirm, session: Session) -> Measured:
    session.emit(Prompt, step=path, text=action.text, choices=("yes", "no"))
    agreed = session.answers.confirm(path, action.text, action.unattended)
    session.emit(Answer, step=path, text="yes" if agreed else "no", by=session.answers.by)
    if not agreed:
        raise AbortedError(f"{path}: '{action.text}' was answered with no")
    return Measured()


def _ask(path: str, action: Ask, session: Session) -> Measured:
    session.emit(Prompt, step=path, text=action.text)
    answer = session.answers.ask(path, action.text, action.unattended)
    session.emit(Answer, step=path, text=answer, by=session.answers.by, into=action.into)
    return Measured()


def _zero(action: Zero, session: Session) -> Measured:
    name = f"{action.role}.{action.channel}"
    mean = _stream_means(action.role, (action.channel,), action.duration_s, session)[name]
    if abs(mean) > action.within:
        raise DataError(
            f"{name} reads {mean:.4g} {action.unit} at rest,"
            f" more than the {action.within:g} {action.unit} allowed",
            hint="is the rig at rest and unloaded? if so, adjust the instrument's zero",
        )
    return Measured({name: mean}, {name: action.unit})


def _set(action: SetDrive, session: Session) -> Measured:
    name = f"{action.role}.{action.drive}"
    actual = session.rig.set(action.role, action.drive, action.value)
    return Measured({name: actual}, {name: action.unit})


def _settle(action: Settle, session: Session) -> Measured:
    for _ in _naps(action.duration_s, session):
        pass
    return Measured()


def _measure(action: Measure, session: Session) -> Measured:
    by_role: dict[str, list[str]] = {}
    for member in action.channels:
        role, channel = split_member(member)
        by_role.setdefault(role, []).append(channel)
    values: dict[str, float] = {}
    for role, channels in by_role.items():
        values |= _values(action, role, channels, session)
    return Measured({member: values[member] for member in action.channels}, action.units)


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
    for block in checked_stream(session.rig, role, channels, duration_s, session.stop):
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
        check_stop(session.stop)
        yield
        clock.sleep(min(left_s, _NAP_S))


def _record(action: Record, session: Session) -> Measured:
    conditions, units = session.rig.conditions(action.role, action.channels)
    for block in checked_stream(
        session.rig, action.role, action.channels, action.duration_s, session.stop
    ):
        session.emit(Samples, recording=action.name, block=block)
    return Measured(conditions, {**action.units, **units}, session.rig.truth(action.role))
