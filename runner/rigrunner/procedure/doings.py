"""What is done at the rig: drives, waiting, and reading."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity, ListOf, PositiveDuration, Settings
from rigrunner.procedure.options import (
    Limits,
    OnFail,
    RecordedLimits,
    Repeatable,
    Retries,
    Timeout,
)
from rigrunner.procedure.refusals import require_one
from rigrunner.yamlfile.names import Name, Text

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

Cycles = Annotated[int, Field(ge=1, le=1_000_000)]
Channels = Annotated[ListOf[Member], Field(min_length=1)]


_OPTIONS = ("timeout", "retries", "repeatable")


class Set(Settings):
    """Drives get a set-point each, in the order in which they stand, and are read back."""

    drives: Annotated[dict[Member, AnyQuantity], Field(min_length=1)]
    """Role and drive, such as tester.load; written beside the other keys."""
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True

    @model_validator(mode="before")
    @classmethod
    def _sort_out_drives(cls, value: object) -> object:
        if not isinstance(value, dict):
            return value
        options = {key: value[key] for key in _OPTIONS if key in value}
        drives = {key: value[key] for key in value if key not in options}
        return {**options, "drives": drives}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of what is written, where drives stand beside the options."""
        schema: dict[str, Any] = handler(core_schema)
        found = handler.resolve_ref_schema(schema)
        drives = found["properties"].pop("drives")
        found["patternProperties"] = drives["patternProperties"]
        found["minProperties"] = drives["minProperties"]
        found.pop("required", None)
        return schema


class Scan(Settings):
    """A drive goes through set-points, and at each one channels are read: one step, one table.

    What is done at each set-point of a sweep may be anything; a scan only reads, and is as quick as
    its devices are.
    """

    set: Member
    """Role and drive, such as press.load."""
    over: Annotated[ListOf[AnyQuantity], Field(min_length=1)]
    """The set-points, in the order in which they are gone through."""
    channels: Channels
    """Roles and channels, such as [press.torque]; read once at each set-point."""
    name: Name = "measured"
    """Of the table of which the values are rows."""
    settle: PositiveDuration | None = None
    """How long to wait at each set-point before it is read."""
    limits: Limits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: Annotated[
        Literal["stop", "continue"],
        Field(
            description="What follows a value out of its limits: the end of the run, or the next"
            " point. A device that fails ends the run: the drive would stand elsewhere than the"
            " steps that follow take for granted."
        ),
    ] = "stop"


class Ramp(Settings):
    """A drive goes to a set-point at a rate, or over a time."""

    drive: Member
    """Role and drive, such as tester.load."""
    from_: Annotated[AnyQuantity | None, Field(alias="from")] = None
    """Where it starts; where it stands, unless told."""
    to: AnyQuantity
    """Where it ends."""
    rate: AnyQuantity | None = None
    """How fast it goes, such as 100 N/s."""
    time: PositiveDuration | None = None
    """How long it takes."""
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        require_one(self, "rate", "time")
        return self


class Wait(Settings):
    """Time passes, whatever the rig does."""

    time: PositiveDuration
    """How long."""
    text: Text | None = None
    """What for, in words."""


class Settle(Settings):
    """Time passes until the motion is steady: cycles of it, or a time."""

    cycles: Cycles | None = None
    """How many cycles of the motion."""
    time: PositiveDuration | None = None
    """How long."""

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        require_one(self, "cycles", "time")
        return self


class Zero(Settings):
    """A channel is read at rest and taken as zero; beyond `within` the step has failed."""

    channel: Member
    """Role and channel, such as tester.torque."""
    within: AnyQuantity
    """How far from zero it may be."""
    duration: PositiveDuration = 1.0
    """How long it is read."""
    limits: Limits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: OnFail = "stop"


class Record(Settings):
    """Channels of one device are recorded: over whole cycles, or for a time."""

    channels: Channels
    """Roles and channels, such as [tester.angle, tester.torque]."""
    cycles: Cycles | None = None
    """How many whole cycles of the motion."""
    duration: PositiveDuration | None = None
    """How long."""
    limits: RecordedLimits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: OnFail = "stop"

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        require_one(self, "cycles", "duration")
        return self


class Measure(Settings):
    """Channels are read once, or averaged over a time; the values are a row of a table."""

    channels: Channels
    """Roles and channels, such as [tester.load, tester.temperature]."""
    name: Name = "measured"
    """Of the table of which the values are a row."""
    duration: PositiveDuration | None = None
    """How long to average, over channels of one device; without it they are read once."""
    limits: Limits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: OnFail = "stop"
