"""The steps of a procedure: each a mapping with one key, which says what it does."""

from __future__ import annotations

import difflib
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from rigrunner.api.settings import AnyQuantity, Duration, ListOf, Settings, YesNo
from rigrunner.yamlfile.names import Member, Name, Text

Cycles = Annotated[int, Field(ge=1, le=1_000_000)]
PositiveDuration = Annotated[Duration, Field(gt=0)]


class Confirm(Settings):
    """A person confirms that something is so; 'no' stops the run."""

    text: Text
    """What is to be confirmed."""
    unattended: YesNo | None = None
    """The answer with `--unattended`; without one the step cannot be done then."""


class Ask(Settings):
    """A person is asked for a value, which becomes the input named by `into`."""

    text: Text
    """The question."""
    into: Name
    """The input that the answer becomes."""
    unattended: str | None = None
    """The answer with `--unattended`; without one the step cannot be done then."""


class Zero(Settings):
    """A channel is read at rest and taken as zero; beyond `within` the run stops."""

    channel: Member
    """Role and channel, such as tester.torque."""
    within: AnyQuantity
    """How far from zero it may be."""
    duration: PositiveDuration = 1.0
    """How long it is read."""


class Settle(Settings):
    """Time passes until the motion is steady: cycles of it, or a time."""

    cycles: Cycles | None = None
    """How many cycles of the motion."""
    time: PositiveDuration | None = None
    """How long."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        _require_one(self, "cycles", "time")
        return self


class Record(Settings):
    """Channels of one device are recorded: over whole cycles, or for a time."""

    channels: Annotated[ListOf[Member], Field(min_length=1)]
    """Roles and channels, such as [tester.angle, tester.torque]."""
    cycles: Cycles | None = None
    """How many whole cycles of the motion."""
    duration: PositiveDuration | None = None
    """How long."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        _require_one(self, "cycles", "duration")
        return self


class Measure(Settings):
    """Channels are read once, or averaged over a time; the values are a row of a table."""

    channels: Annotated[ListOf[Member], Field(min_length=1)]
    """Roles and channels, such as [tester.load, tester.temperature]."""
    name: Name = "measured"
    """Of the table of which the values are a row."""
    duration: PositiveDuration | None = None
    """How long to average, over channels of one device; without it they are read once."""


class Sweep(Settings):
    """A drive goes through a list of set-points; at each the steps are done."""

    set: Member
    """Role and drive, such as tester.frequency."""
    over: Annotated[ListOf[AnyQuantity], Field(min_length=1)]
    """The set-points, in the order in which they are gone through."""
    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """What is done at each."""


class ConfirmStep(Settings):
    """`confirm: {text: ..., unattended: yes}`."""

    confirm: Confirm


class AskStep(Settings):
    """`ask: {text: ..., into: name}`."""

    ask: Ask


class ZeroStep(Settings):
    """`zero: {channel: role.name, within: 0.05 N·m}`."""

    zero: Zero


class SetStep(Settings):
    """`set: {role.drive: 1000 N}`; several drives are set in the order in which they stand."""

    set: Annotated[dict[Member, AnyQuantity], Field(min_length=1)]


class SettleStep(Settings):
    """`settle: {cycles: 5}` or `settle: {time: 2 s}`."""

    settle: Settle


class SweepStep(Settings):
    """`sweep: {set: role.drive, over: [1 Hz, 2 Hz], steps: [...]}`."""

    sweep: Sweep


class RecordStep(Settings):
    """`record: {channels: [role.name], cycles: 30}` or `duration: 10 s`."""

    record: Record


class MeasureStep(Settings):
    """`measure: {channels: [role.name]}`, read once, or averaged with `duration: 2 s`."""

    measure: Measure


STEPS = ("confirm", "ask", "zero", "set", "settle", "sweep", "record", "measure")


def _kind(value: object) -> str | None:
    if isinstance(value, Settings):
        return next(iter(type(value).model_fields))
    return next(iter(value)) if isinstance(value, dict) else None


def _one_known_key(value: Any) -> Any:
    """Refuse what is no mapping with one known key before any alternative is tried."""
    if isinstance(value, Settings):
        return value
    known = f"allowed is one of: {', '.join(STEPS)}"
    if not isinstance(value, dict):
        raise _refused(f"a step is a mapping with one key, such as 'settle: ...'; {known}")
    keys = [str(key) for key in value]
    if len(keys) != 1:
        got = " and ".join(f"'{key}'" for key in keys[:5]) or "none"
        hint = "begin each step with its own '-'" if keys else ""
        raise _refused(f"a step has one key, got {got}; {known}", hint)
    if keys[0] not in STEPS:
        near = difflib.get_close_matches(keys[0], STEPS, n=1)
        raise _refused(
            f"unknown step '{keys[0][:40]}'; {known}", f"did you mean '{near[0]}'?" if near else ""
        )
    return value


Step = Annotated[
    Annotated[ConfirmStep, Tag("confirm")]
    | Annotated[AskStep, Tag("ask")]
    | Annotated[ZeroStep, Tag("zero")]
    | Annotated[SetStep, Tag("set")]
    | Annotated[SettleStep, Tag("settle")]
    | Annotated[SweepStep, Tag("sweep")]
    | Annotated[RecordStep, Tag("record")]
    | Annotated[MeasureStep, Tag("measure")],
    Discriminator(_kind),
    BeforeValidator(_one_known_key),
]


def _require_one(model: Settings, first: str, second: str) -> None:
    given = [name for name in (first, second) if getattr(model, name) is not None]
    if len(given) != 1:
        got = "both" if given else "neither"
        raise _refused(f"got {got}, allowed is one of: {first}, {second}")


def _refused(message: str, hint: str = "") -> PydanticCustomError:
    return PydanticCustomError("step", "{message}", {"message": message, "hint": hint})


Sweep.model_rebuild()
SweepStep.model_rebuild()
