"""`measure`: channels are read once, or averaged over a time; the values are a row of a table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from statistics import fmean
from typing import TYPE_CHECKING, NamedTuple

from pydantic import Field

from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Name
from rigrunner.api.settings import PositiveDuration
from rigrunner.api.steps import NONE, Action, Rows, StepResult, StepSettings
from rigrunner.procedure.options import Channels, Limits, OnFail, Repeatable, Retries, Timeout

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.devices import ReadingInfo
    from rigrunner.api.member import Member
    from rigrunner.engine.session import Session
    from rigrunner.plan.bench import Bench
    from rigrunner.plan.planning import Planning
    from rigrunner.procedure.options import ValueBand


class MeasureStep(StepSettings):
    """Reads channels once, or averages them over a time; the values are a row of a table."""

    channels: Channels
    """Roles and channels, such as [tester.load, tester.temperature]; also readings such as texts.
    """
    name: Name = "measured"
    """Name of the table."""
    duration: PositiveDuration | None = None
    """Averaging time, for channels of one device; without it they are read once."""
    limits: Limits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: OnFail = "stop"


@dataclass(frozen=True, slots=True)
class Measure(Action):
    """Reads channels once, or averages them over a time."""

    kind = "measure"
    reads = drives_stay = True
    name: str
    """Name of the table."""
    channels: tuple[Member, ...]
    """Of one role if they are averaged."""
    duration_s: float
    """Averaging time; 0: read once."""
    setpoints: Mapping[str, float]
    """As for a recording."""
    units: Mapping[str, str]
    """As for a recording."""
    sample_rate_hz: float | None = None
    """Rate of the stream that is averaged; None: the channels are read repeatedly."""
    told: tuple[Member, ...] = ()
    """Readings that are not numbers."""

    @property
    def streamed(self) -> str:
        """The role of the stream that is averaged."""
        return self.channels[0].role if self.sample_rate_hz else ""

    @property
    def rows(self) -> Rows:
        """Its one row."""
        return Rows(self.name, self.channels, self.units, (self.setpoints,))

    @property
    def table(self) -> str:
        """Its table."""
        return self.name

    @property
    def setpoints_and_units(self) -> tuple[Mapping[str, float], Mapping[str, str]]:
        """Set-points of the drives, and the units."""
        return self.setpoints, self.units

    def do(self, step: str, doing: Session) -> StepResult:  # noqa: ARG002  (its errors name the role)
        """Read, or average."""
        readings = doing.observe(self.told) if self.told else NONE
        return StepResult(self._values(doing), self.units, readings=readings)

    def _values(self, doing: Session) -> Mapping[str, float]:
        if not self.channels:
            return NONE
        if not self.duration_s:
            return doing.read(self.channels)
        if self.sample_rate_hz is not None:
            names = [channel.name for channel in self.channels]
            return doing.stream_means(self.channels[0].role, names, self.duration_s)
        readings = [doing.read(self.channels) for _ in doing.naps(self.duration_s)]
        return {name: fmean(reading[name] for reading in readings) for name in self.channels}


class _Listed(NamedTuple):
    """What a step lists: the same each time that it is planned."""

    numbers: tuple[Member, ...]
    readings: Mapping[Member, ReadingInfo]
    """Readings that are not numbers."""
    reading_units: dict[Member, str]
    limits_of_numbers: Mapping[Member, ValueBand]
    limits_of_readings: Mapping[Member, ValueBand]
    text: str

    @classmethod
    def of(cls, measure: MeasureStep, bench: Bench) -> _Listed:
        infos = {channel: bench.reading(channel) for channel in measure.channels}
        readings = {member: info for member, info in infos.items() if info is not None}
        how = f"mean over {measure.duration:.3g} s" if measure.duration else "once"
        return cls(
            tuple(channel for channel in measure.channels if channel not in readings),
            readings,
            {member: info.unit for member, info in readings.items() if info.unit},
            {member: band for member, band in measure.limits.items() if member not in readings},
            {member: band for member, band in measure.limits.items() if member in readings},
            f"Measure {', '.join(measure.channels)}, {how}",
        )


def plan(measure: MeasureStep, planning: Planning) -> None:
    """Plan single readings, or an average."""
    scene, place, seconds = planning.scene, planning.place, measure.duration or 0.0
    listed = scene.cached(place, "listed", partial(_Listed.of, measure, scene.bench))
    numbers, readings = listed.numbers, listed.readings
    units = planning.units(numbers)
    twice = len(set(measure.channels)) < len(measure.channels)
    if twice or (numbers and not units):
        # Numbers that are listed twice are a problem of `planning.units` already.
        if twice and len(set(numbers)) == len(numbers):
            planning.complain(("channels",), "a channel is listed twice", "name it once")
        return
    if seconds and readings:
        message = f"{', '.join(readings)}: what is not a number has no mean"
        planning.complain(("channels",), message, "a measure step of its own, without a duration")
    rate_hz = _averaging_rate_hz(numbers, planning) if seconds and numbers else None
    # Without a stream the channels are read one by one, so their devices must be readable.
    if rate_hz is None:
        planning.must_be_read(units)
    action = Measure(
        name=measure.name,
        channels=numbers,
        duration_s=seconds,
        setpoints=planning.setpoints(),
        units=scene.shared(place, "units", planning.drive_units() | units | listed.reading_units),
        told=tuple(readings),
        sample_rate_hz=rate_hz,
    )
    limits = planning.limits(listed.limits_of_numbers, numbers)
    from rigrunner.plan.terms import reading_limits  # noqa: PLC0415  (numpy: to check a procedure needs none)

    expected = reading_limits(listed.limits_of_readings, readings, place, scene)
    planning.emit(action, listed.text, seconds, limits, expected=expected)


def _averaging_rate_hz(channels: Sequence[Member], planning: Planning) -> float | None:
    """Return the rate of the stream that is averaged; None without one."""
    first, *others = sorted({member.role for member in channels})
    if others:
        message = f"channels of two devices in one average: {first}, {', '.join(others)}"
        hint = "a measure step for each device, or no duration"
        planning.complain(("channels",), message, hint)
    bench = planning.scene.bench
    if not all(bench.streams(member) for member in channels):
        return None
    return bench.sample_rate_hz(first, planning.place.path)


STEP = StepRecord(
    name="measure",
    help="Reads channels once, or averages them over a time; the values are a row of a table.",
    settings=MeasureStep,
    factory=plan,
    example="measure: {channels: [role.name]}`, read once, or averaged with `duration: 2 s",
    trial={"channels": ["tester.load"]},
)
