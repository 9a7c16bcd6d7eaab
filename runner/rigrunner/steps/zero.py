"""`zero`: a channel is read at rest and its reading subtracted later."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydantic import Field

from rigrunner.api.errors import DataError
from rigrunner.api.hooks import StepRecord
from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity, PositiveDuration
from rigrunner.api.steps import Action, StepResult, StepSettings
from rigrunner.procedure.options import Limits, OnFail, Repeatable, Retries, Timeout

if TYPE_CHECKING:
    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning


class ZeroStep(StepSettings):
    """Reads a channel at rest as its zero; fails beyond `within`."""

    channel: Member
    """Role and channel, such as tester.torque."""
    within: AnyQuantity
    """Largest accepted distance from zero."""
    duration: PositiveDuration = 1.0
    """Duration of the reading."""
    limits: Limits = Field(default_factory=dict)
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True
    on_fail: OnFail = "stop"


@dataclass(frozen=True)
class Zero(Action):
    """Reads a channel at rest; fails beyond `within` (SI unit of the channel)."""

    kind = "zero"
    reads = True
    role: str
    channel: str
    unit: str
    within: float
    duration_s: float

    @property
    def zeroed(self) -> Member:
        """The channel."""
        return Member(self.role, self.channel)

    @property
    def streamed(self) -> str:
        """The role of the channel."""
        return self.role

    def do(self, step: str, doing: Session) -> StepResult:  # noqa: ARG002  (its errors name the channel)
        """Read it; raise DataError if its mean is too far from zero."""
        import numpy as np  # noqa: PLC0415  (to check a procedure needs none)

        from rigrunner.signal.effective_samples import scatter_of_mean  # noqa: PLC0415  (as above)

        name = self.zeroed
        blocks = doing.stream(self.role, (self.channel,), self.duration_s)
        samples = [block.channels[name] for block in blocks if block.samples]
        if not samples:
            raise DataError(f"{name}: no sample came in {self.duration_s:g} s")
        mean = sum(float(sample.sum()) for sample in samples) / sum(map(len, samples))
        if abs(mean) > self.within:
            raise DataError(
                f"{name} reads {mean:.4g} {self.unit} at rest,"
                f" more than the {self.within:g} {self.unit} allowed",
                hint="is the rig at rest and unloaded? if so, adjust the instrument's zero",
            )
        scatter = scatter_of_mean(np.concatenate(samples))
        return StepResult({name: mean}, {name: self.unit}, scatter={name: scatter})


def plan(zero: ZeroStep, planning: Planning) -> None:
    """Plan the reading."""
    bench, at, member = planning.scene.bench, planning.path("channel"), zero.channel
    channel = planning.channel(member, ("channel",))
    if channel is None or bench.sample_rate_hz(member.role, at) is None:
        return
    if not bench.can_record(member, at):
        return
    if not planning.fits(zero.within, channel.unit, member, ("within",)):
        return
    if zero.within.si <= 0:
        planning.complain(("within",), f"got '{zero.within}', expected more than 0")
    planning.require_rest(member.role)
    action = Zero(member.role, member.name, channel.unit, zero.within.si, zero.duration)
    limits = planning.limits(zero.limits, [member])
    planning.emit(action, f"Zero {member}, within {zero.within}", zero.duration, limits)


STEP = StepRecord(
    name="zero",
    help="Reads a channel at rest as its zero.",
    settings=ZeroStep,
    factory=plan,
    example="zero: {channel: role.name, within: 0.05 N·m}",
    trial={"channel": "tester.torque", "within": "1 N·m"},
)
