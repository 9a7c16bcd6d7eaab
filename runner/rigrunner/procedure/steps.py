"""The steps of a procedure: each a mapping with one key, which says what it does."""

from __future__ import annotations

import difflib
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag

from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity, ListOf, Settings
from rigrunner.procedure.doings import Measure, Ramp, Record, Scan, Set, Settle, Wait, Zero
from rigrunner.procedure.questions import Ask, Confirm, Note
from rigrunner.procedure.refusals import refused
from rigrunner.yamlfile.names import Name, Text

Scalar = str | bool | int | float
Parameter = Scalar | list[Scalar]


class Sweep(Settings):
    """A drive goes through a list of set-points; at each the steps are done."""

    set: Member
    """Role and drive, such as tester.frequency."""
    over: Annotated[ListOf[AnyQuantity], Field(min_length=1)]
    """The set-points, in the order in which they are gone through."""
    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """What is done at each."""


class Repeat(Settings):
    """Steps are done several times."""

    times: Annotated[int, Field(ge=1, le=100_000)]
    """How often."""
    steps: Annotated[ListOf[Step], Field(min_length=1)]
    """What is done each time."""


class Call(Settings):
    """The steps of another procedure are done: its setup, main and teardown."""

    procedure: Text
    """The file, beside this one or in a folder below."""
    with_: Annotated[dict[Name, Parameter], Field(alias="with", default_factory=dict)]
    """Values for its parameters, in the place of its own."""


class ConfirmStep(Settings):
    """`confirm: {text: ..., unattended: yes}`."""

    confirm: Confirm


class AskStep(Settings):
    """`ask: {text: ..., into: name}`."""

    ask: Ask


class NoteStep(Settings):
    """`note: {text: ...}`."""

    note: Note


class ZeroStep(Settings):
    """`zero: {channel: role.name, within: 0.05 N·m}`."""

    zero: Zero


class SetStep(Settings):
    """`set: {role.drive: 1000 N}`; several drives are set in the order in which they stand."""

    set: Set


class RampStep(Settings):
    """`ramp: {drive: role.drive, to: 1000 N, rate: 100 N/s}` or `time: 10 s`."""

    ramp: Ramp


class WaitStep(Settings):
    """`wait: {time: 5 min}`."""

    wait: Wait


class SettleStep(Settings):
    """`settle: {cycles: 5}` or `settle: {time: 2 s}`."""

    settle: Settle


class SweepStep(Settings):
    """`sweep: {set: role.drive, over: [1 Hz, 2 Hz], steps: [...]}`."""

    sweep: Sweep


class RepeatStep(Settings):
    """`repeat: {times: 3, steps: [...]}`."""

    repeat: Repeat


class RecordStep(Settings):
    """`record: {channels: [role.name], cycles: 30}` or `duration: 10 s`."""

    record: Record


class MeasureStep(Settings):
    """`measure: {channels: [role.name]}`, read once, or averaged with `duration: 2 s`."""

    measure: Measure


class ScanStep(Settings):
    """`scan: {set: role.drive, over: [1 N, 2 N], channels: [role.name]}`."""

    scan: Scan


class CallStep(Settings):
    """`call: {procedure: file.yaml, with: {name: value}}`."""

    call: Call


STEPS = (
    *("confirm", "ask", "note", "zero", "set", "ramp", "wait", "settle"),
    *("sweep", "repeat", "record", "measure", "scan", "call"),
)


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
        raise refused(f"a step is a mapping with one key, such as 'settle: ...'; {known}")
    keys = [str(key) for key in value]
    if len(keys) != 1:
        got = " and ".join(f"'{key}'" for key in keys[:5]) or "none"
        hint = "begin each step with its own '-'" if keys else ""
        raise refused(f"a step has one key, got {got}; {known}", hint)
    if keys[0] not in STEPS:
        near = difflib.get_close_matches(keys[0], STEPS, n=1)
        raise refused(
            f"unknown step '{keys[0][:40]}'; {known}", f"did you mean '{near[0]}'?" if near else ""
        )
    return value


Step = Annotated[
    Annotated[ConfirmStep, Tag("confirm")]
    | Annotated[AskStep, Tag("ask")]
    | Annotated[NoteStep, Tag("note")]
    | Annotated[ZeroStep, Tag("zero")]
    | Annotated[SetStep, Tag("set")]
    | Annotated[RampStep, Tag("ramp")]
    | Annotated[WaitStep, Tag("wait")]
    | Annotated[SettleStep, Tag("settle")]
    | Annotated[SweepStep, Tag("sweep")]
    | Annotated[RepeatStep, Tag("repeat")]
    | Annotated[RecordStep, Tag("record")]
    | Annotated[MeasureStep, Tag("measure")]
    | Annotated[ScanStep, Tag("scan")]
    | Annotated[CallStep, Tag("call")],
    Discriminator(_kind),
    BeforeValidator(_one_known_key),
]
