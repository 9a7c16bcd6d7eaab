"""Walks a procedure and writes down every single action."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.plan.actions import (
    Action,
    Ask,
    Confirm,
    Measure,
    Phase,
    PlannedStep,
    Record,
    SetDrive,
    Settle,
    Zero,
)
from rigrunner.plan.drives import DriveStates
from rigrunner.procedure import steps as language
from rigrunner.yamlfile.names import split_member

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api.quantity import Quantity
    from rigrunner.plan.bench import Bench
    from rigrunner.plan.problems import Problems
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.yamlfile.document import Path

MAX_ACTIONS = 100_000
_LEAST_DIGITS = 3


@dataclass(frozen=True)
class Place:
    """A step in the file, and in the run, where a sweep's steps come once for each value."""

    phase: Phase
    path: Path
    label: str

    def inside(self, *parts: str) -> Place:
        """Return the place of a part of the step."""
        return Place(self.phase, self.path + parts, ".".join((self.label, *parts)))

    def step(self, index: int) -> Place:
        """Return the place of a step in the list that stands here."""
        return Place(self.phase, (*self.path, index), f"{self.label}[{index}]")

    def value(self, index: int) -> Place:
        """Return the place of a sweep's steps at one of its values; in the file it is the same."""
        return Place(self.phase, self.path, f"{self.label}[{index}]")


class Builder:
    """Turns the steps of a procedure into planned steps; what cannot be done is a problem."""

    def __init__(self, procedure: LoadedProcedure, bench: Bench, problems: Problems) -> None:
        self._procedure = procedure.model
        self._document = procedure.document
        self._bench = bench
        self._problems = problems
        self._drives = DriveStates(bench, procedure.document, problems)
        self.wanted = 0
        self.steps: list[PlannedStep] = []
        self.recordings: list[tuple[Record, Path]] = []

    def build(self) -> None:
        """Fill `steps` and `recordings`; `wanted` is how many recordings are asked for."""
        sections = {phase: getattr(self._procedure, phase.value) for phase in Phase}
        self._refuse_endless(sum(_count(steps, _actions_of) for steps in sections.values()))
        self.wanted = sum(_count(steps, _recordings_of) for steps in sections.values())
        for phase, steps in sections.items():
            self._walk(steps, Place(phase, (phase.value,), phase.value))

    def _refuse_endless(self, actions: int) -> None:
        if actions <= MAX_ACTIONS:
            return
        message = f"the procedure has {actions:,} actions, more than {MAX_ACTIONS:,}"
        self._problems.add(self._document, ("main",), message, "look at nested sweeps", key=True)
        self._problems.stop_if_any()

    def _walk(self, steps: Sequence[language.Step], place: Place) -> None:
        for index, step in enumerate(steps):
            self._step(step, place.step(index))

    def _step(self, step: language.Step, place: Place) -> None:
        match step:
            case language.ConfirmStep(confirm=confirm):
                question = Confirm(confirm.text, confirm.unattended)
                self._emit(place.inside("confirm"), question, confirm.text)
            case language.AskStep(ask=ask):
                request = Ask(ask.text, ask.into, ask.unattended)
                self._emit(place.inside("ask"), request, ask.text)
            case language.ZeroStep(zero=zero):
                self._zero(zero, place.inside("zero"))
            case language.SetStep(set=targets):
                for member, quantity in targets.items():
                    at = place.inside("set", member)
                    self._set(member, quantity, at, named_at=at.path, key=True)
            case language.SettleStep(settle=settle):
                self._settle(settle, place.inside("settle"))
            case language.SweepStep(sweep=sweep):
                self._sweep(sweep, place.inside("sweep"))
            case language.RecordStep(record=record):
                self._record(record, place.inside("record"))
            case language.MeasureStep(measure=measure):
                self._measure(measure, place.inside("measure"))

    def _emit(self, place: Place, action: Action, text: str, seconds: float = 0.0) -> None:
        self.steps.append(PlannedStep(place.label, place.phase, action, text, seconds))

    def _zero(self, zero: language.Zero, place: Place) -> None:
        at = (*place.path, "channel")
        role, name = split_member(zero.channel)
        channel = self._bench.channel(zero.channel, at)
        if channel is None or self._bench.sample_rate_hz(role, at) is None:
            return
        within = (*place.path, "within")
        if not self._bench.fits(zero.within, channel.unit, zero.channel, within):
            return
        if zero.within.si <= 0:
            message = f"got '{zero.within}', allowed is more than 0"
            self._problems.add(self._document, within, message)
        self._drives.require_rest(role, place.path)
        action = Zero(role, name, channel.unit, zero.within.si, zero.duration)
        self._emit(place, action, f"Zero {zero.channel}, within {zero.within}", zero.duration)

    def _set(
        self, member: str, quantity: Quantity, place: Place, *, named_at: Path, key: bool
    ) -> None:
        drive = self._drives.resolve(member, quantity, named_at, place.path, key=key)
        if drive is None:
            return
        seconds = self._drives.move(member, drive, quantity.si)
        role, name = split_member(member)
        action = SetDrive(role, name, quantity.si, drive.unit)
        self._emit(place, action, f"Set {member} to {quantity}", seconds)

    def _settle(self, settle: language.Settle, place: Place) -> None:
        if settle.time is not None:
            text = f"Settle for {settle.time:.3g} s"
            self._emit(place, Settle(settle.time), text, settle.time)
            return
        frequency_hz = self._drives.cycle_frequency_hz(None, (*place.path, "cycles"))
        if frequency_hz and settle.cycles:
            seconds = settle.cycles / frequency_hz
            text = f"Settle for {settle.cycles} cycles ({seconds:.3g} s)"
            self._emit(place, Settle(seconds), text, seconds)

    def _sweep(self, sweep: language.Sweep, place: Place) -> None:
        for index, quantity in enumerate(sweep.over):
            at = Place(place.phase, (*place.path, "over", index), f"{place.label}[{index}].set")
            self._set(sweep.set, quantity, at, named_at=(*place.path, "set"), key=False)
            self._walk(sweep.steps, place.value(index).inside("steps"))

    def _record(self, record: language.Record, place: Place) -> None:
        role, units = self._channels(record, place)
        if not units:
            return
        duration_s, span = self._span(record, role, place)
        frequency_hz = self._drives.known_cycle_frequency_hz(role)
        digits = max(_LEAST_DIGITS, len(str(self.wanted)))
        number = f"{len(self.recordings) + 1:0{digits}d}"
        action = Record(
            name=number if frequency_hz is None else f"{number}_{frequency_hz:.6g}Hz",
            role=role,
            channels=tuple(split_member(member)[1] for member in record.channels),
            duration_s=duration_s,
            setpoints=self._drives.values(),
            units=self._drives.units() | units,
            cycle_frequency_hz=frequency_hz,
            sample_rate_hz=self._bench.sample_rate_hz(role, place.path),
        )
        self.recordings.append((action, place.path))
        text = f"Record {', '.join(action.channels)} of {role}, {span} ({duration_s:.3g} s)"
        self._emit(place, action, text, duration_s)

    def _measure(self, measure: language.Measure, place: Place) -> None:
        units = self._channel_units(measure.channels, place)
        if not units:
            return
        seconds = measure.duration or 0.0
        rate_hz = self._averaging_rate_hz(measure, place) if seconds else None
        if rate_hz is None:
            for role in {split_member(member)[0] for member in units}:
                self._bench.must_be_readable(role, place.path)
        action = Measure(
            name=measure.name,
            channels=measure.channels,
            duration_s=seconds,
            setpoints=self._drives.values(),
            units=self._drives.units() | units,
            sample_rate_hz=rate_hz,
        )
        how = f"mean over {seconds:.3g} s" if seconds else "once"
        self._emit(place, action, f"Measure {', '.join(measure.channels)}, {how}", seconds)

    def _averaging_rate_hz(self, measure: language.Measure, place: Place) -> float | None:
        """Return the rate of the stream that is averaged; None where there is none."""
        first, *others = sorted({split_member(member)[0] for member in measure.channels})
        if others:
            message = f"channels of two devices in one average: {first}, {', '.join(others)}"
            hint = "a measure step for each device, or no duration"
            self._problems.add(self._document, (*place.path, "channels"), message, hint)
        return self._bench.sample_rate_hz(first, place.path) if self._bench.streams(first) else None

    def _channels(self, record: language.Record, place: Place) -> tuple[str, dict[str, str]]:
        """Return the role and each channel's unit; no units where there is a problem with them."""
        path = (*place.path, "channels")
        units = self._channel_units(record.channels, place)
        roles = sorted({split_member(member)[0] for member in record.channels})
        if len(roles) > 1:
            message = f"channels of two devices in one recording: {', '.join(roles)}"
            self._problems.add(self._document, path, message, "one clock, one device, one record")
            return roles[0], {}
        return roles[0], units

    def _channel_units(self, channels: Sequence[str], place: Place) -> dict[str, str]:
        """Return each channel's unit; none at all where there is a problem with one."""
        path = (*place.path, "channels")
        found = {
            member: self._bench.channel(member, (*path, index))
            for index, member in enumerate(channels)
        }
        if len(found) < len(channels):
            self._problems.add(self._document, path, "a channel stands twice", "name it once")
            return {}
        units = {member: info.unit for member, info in found.items() if info}
        return units if len(units) == len(found) else {}

    def _span(self, record: language.Record, role: str, place: Place) -> tuple[float, str]:
        """Return how long to record: a cycle more than asked for, so that as many are whole.

        Zero, which no plan is made of, where a problem keeps it from being known.
        """
        if record.duration is not None:
            return record.duration, "for a time"
        frequency_hz = self._drives.cycle_frequency_hz(role, (*place.path, "cycles"))
        if not frequency_hz or record.cycles is None:
            return 0.0, ""
        duration_s = (record.cycles + 1) / frequency_hz
        return duration_s, f"{record.cycles} cycles at {frequency_hz:.6g} Hz"


def _count(steps: Sequence[language.Step], weight: Callable[[language.Step], int]) -> int:
    total = 0
    for step in steps:
        if isinstance(step, language.SweepStep):
            inner = weight(step) + _count(step.sweep.steps, weight)
            total += len(step.sweep.over) * inner
        else:
            total += weight(step)
    return total


def _actions_of(step: language.Step) -> int:
    return len(step.set) if isinstance(step, language.SetStep) else 1


def _recordings_of(step: language.Step) -> int:
    return int(isinstance(step, language.RecordStep))
