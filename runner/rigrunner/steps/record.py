"""`record`: channels of one device are recorded, over whole cycles or for a time.

Of a repeated recording, `keep_every` keeps the samples of some, and the `statistics` of all: the
disk space is then bounded, however long the run.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api.coordinates import written_text
from rigrunner.api.events import Samples
from rigrunner.api.hooks import StepRecord
from rigrunner.api.member import Member
from rigrunner.api.settings import ListOf, PositiveDuration
from rigrunner.api.steps import Action, StepResult, StepSettings
from rigrunner.procedure.options import (
    Channels,
    Cycles,
    OnFail,
    RecordedLimits,
    Repeatable,
    Retries,
    SampleStatistic,
    Timeout,
)
from rigrunner.procedure.refusals import refusal, require_one

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning

_LEAST_DIGITS = 3
_LONGEST_NAME = 100


class RecordStep(StepSettings):
    """Records channels of one device, over whole cycles or for a time."""

    channels: Channels
    """Roles and channels, such as [tester.angle, tester.torque]."""
    cycles: Cycles | None = None
    """Number of whole cycles of the motion."""
    duration: PositiveDuration | None = None
    """Duration."""
    statistics: dict[Member, Annotated[ListOf[SampleStatistic], Field(min_length=1)]] = Field(
        default_factory=dict
    )
    """By channel, statistics of the samples for a row of the table `recorded`."""
    keep_every: Annotated[int | None, Field(ge=2, le=100_000)] = None
    """For a repeated recording: keep the samples of the first and of each n-th after it, of the
    others only the statistics. Counted separately at each set-point."""
    limits: RecordedLimits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: OnFail = "stop"

    def recordings(self) -> int:
        """Return 1."""
        return 1

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        require_one(self, "cycles", "duration")
        if self.keep_every and not self.statistics:
            raise refusal(
                "the key 'statistics' is missing: without it nothing is kept of the others",
                "such as statistics: {tester.torque: [mean, rms]}",
            )
        return self


@dataclass(frozen=True)
class Record(Action):
    """Records channels of one device."""

    kind = "record"
    reads = drives_stay = True
    name: str
    role: str
    channels: tuple[str, ...]
    duration_s: float
    setpoints: Mapping[str, float]
    """All drives set so far by the procedure: 'role.drive' to value in SI units."""
    units: Mapping[str, str]
    """The unit of each channel and drive: 'role.name' to symbol."""
    cycle_frequency_hz: float | None = None
    """Set frequency of the cyclic motion; None without one."""
    sample_rate_hz: float | None = None
    """Rate stated by the device before it is connected; None if unknown."""
    statistics: tuple[str, ...] = ()
    """Statistics of its samples that are kept or have limits, as 'role.name.statistic'."""
    kept: bool = True
    """Whether its samples are kept."""

    @property
    def streamed(self) -> str:
        """The role of its channels."""
        return self.role

    @property
    def recording(self) -> str:
        """Its name; '' if its samples are not kept."""
        return self.name if self.kept else ""

    @property
    def setpoints_and_units(self) -> tuple[Mapping[str, float], Mapping[str, str]]:
        """Set-points of the drives, and the units."""
        return self.setpoints, self.units

    def for_attempt(self, total: int) -> Record:
        """Return it with a unique name, since each attempt makes a recording."""
        return self if total == 1 else replace(self, name=f"{self.name}_try{total}")

    def do(self, step: str, doing: Session) -> StepResult:  # noqa: ARG002  (its errors name the role)
        """Record each block as it comes, and what can be read meanwhile."""
        from rigrunner.engine.recorded import RecordedStatistics  # noqa: PLC0415  (numpy: to check a procedure needs none)

        rig = doing.rig
        conditions, units = rig.conditions(self.role, self.channels)
        statistics = RecordedStatistics(self.statistics)
        for block in doing.stream(self.role, self.channels, self.duration_s):
            doing.emit(Samples, recording=self.recording, block=block)
            statistics.take(block.channels)
        streamed, streamed_units = rig.stream_conditions(self.role)
        values, units = {**conditions, **streamed}, {**self.units, **units, **streamed_units}
        return StepResult(values, units, rig.truth(self.role), statistics.by_name())


def plan(record: RecordStep, planning: Planning) -> None:
    """Plan the recording."""
    role, units = _one_role(record, planning)
    if not units:
        return
    scene = planning.scene
    duration_s, span = _span(record, role, planning)
    frequency_hz = scene.drives.known_cycle_frequency_hz(role)
    names = tuple(member.name for member in record.channels)
    beside = scene.bench.conditions(role, names)
    limits = planning.recorded_limits(record.limits, record.channels, beside)
    # Channels that are read beside the stream have values, and no statistics.
    limited = [limit.of for limit in limits if limit.of not in beside]
    setpoints = planning.setpoints()
    interval = record.keep_every
    kept = interval is None or planning.times_before(*setpoints.items()) % interval == 0
    draft = scene.draft
    digits = max(_LEAST_DIGITS, len(str(draft.recordings_total)))
    number = f"{len(draft.recordings) + 1:0{digits}d}"
    action = Record(
        name=_name(number, frequency_hz, planning),
        role=role,
        channels=names,
        duration_s=duration_s,
        setpoints=setpoints,
        units=planning.drive_units() | units,
        cycle_frequency_hz=frequency_hz,
        sample_rate_hz=scene.bench.sample_rate_hz(role, planning.place.path),
        statistics=tuple(dict.fromkeys((*_statistics(record, planning), *limited))),
        kept=kept,
    )
    if kept:
        planning.record(action, beside)
    channels = ", ".join(action.channels)
    text = f"Record {channels} of {role}, {span} ({duration_s:.3g} s)"
    if not kept:
        text = f"Keep statistics of {channels} of {role}, {span} ({duration_s:.3g} s)"
    planning.emit(action, text, duration_s, limits)


def _name(number: str, frequency_hz: float | None, planning: Planning) -> str:
    """Return a name from number, frequency and coordinates: '004_10Hz_wear_block3'."""
    place = planning.place
    parts = [number, *([] if frequency_hz is None else [f"{frequency_hz:.6g}Hz"])]
    for name, value in place.coordinates.items():
        unit, written = place.coordinate_units.get(name, ""), place.written_in.get(name, "")
        text = written_text(value, unit, written)
        # A text says what it is, such as "wear"; a number needs its name: "block3".
        parts.append(re.sub(r"[^\w.+-]+", "", text if isinstance(value, str) else name + text))
    return "_".join(parts)[:_LONGEST_NAME]


def _statistics(record: RecordStep, planning: Planning) -> Iterator[str]:
    """Yield the statistics to keep; those of a channel that is not recorded are a problem."""
    for member, names in record.statistics.items():
        if member not in record.channels:
            hint = f"recorded: {', '.join(record.channels)}"
            message = f"{member} is not recorded by this step"
            planning.scene.complain(planning.path("statistics", member), message, hint, key=True)
        for name in names:
            yield f"{member}.{name}"


def _one_role(record: RecordStep, planning: Planning) -> tuple[str, dict[Member, str]]:
    """Return the role and the unit of each channel; no units after a problem."""
    units = planning.units(record.channels)
    roles = sorted({member.role for member in record.channels})
    if len(roles) > 1:
        message = f"channels of two devices in one recording: {', '.join(roles)}"
        planning.complain(("channels",), message, "one clock, one device, one record")
        return roles[0], {}
    recordable = [
        planning.scene.bench.can_record(member, planning.path("channels", index))
        for index, member in enumerate(record.channels)
        if member in units
    ]
    return roles[0], units if all(recordable) else {}


def _span(record: RecordStep, role: str, planning: Planning) -> tuple[float, str]:
    """Return the duration: one cycle more than requested, so that as many are whole.

    Zero after a problem; there is no plan then.
    """
    if record.duration is not None:
        return record.duration, "for a time"
    frequency_hz = planning.scene.drives.cycle_frequency_hz(role, planning.path("cycles"))
    if not frequency_hz or record.cycles is None:
        return 0.0, ""
    duration_s = (record.cycles + 1) / frequency_hz
    return duration_s, f"{record.cycles} cycles at {frequency_hz:.6g} Hz"


STEP = StepRecord(
    name="record",
    help="Records channels of one device, over whole cycles or for a time.",
    settings=RecordStep,
    factory=plan,
    example="record: {channels: [role.name], cycles: 30}` or `duration: 10 s",
    trial={"channels": ["tester.torque"], "duration": "3 s"},
)
