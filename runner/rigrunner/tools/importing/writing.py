"""Write the events of an imported run, and that no device was accessed."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import TYPE_CHECKING, Any

from rigrunner.api.data import Block
from rigrunner.api.errors import DataError, Location
from rigrunner.api.events import (
    Intervention,
    Note,
    Outcome,
    RunEnded,
    RunStarted,
    Samples,
    Scanned,
)
from rigrunner.api.member import Member
from rigrunner.api.quantity import Quantity
from rigrunner.api.steps import StepResult
from rigrunner.api.units import si_symbol, unit
from rigrunner.clock import utc_text
from rigrunner.engine.attempt import Attempt
from rigrunner.engine.limits import remarks_on
from rigrunner.engine.recorded import RecordedStatistics
from rigrunner.signal.effective_samples import scatter_of_mean
from rigrunner.steps.measure import Measure
from rigrunner.steps.record import Record
from rigrunner.steps.scan import Scan
from rigrunner.steps.zero import Zero
from rigrunner.tools.importing.columns import MappedColumn, fault, read_part
from rigrunner.tools.importing.mapping import ColumnSpec

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.data import Array
    from rigrunner.api.events import Event, EventSink
    from rigrunner.api.progress import Progress
    from rigrunner.bus import Emit
    from rigrunner.engine import Override
    from rigrunner.plan.actions import PlannedStep
    from rigrunner.tools.importing.columns import RecordingData
    from rigrunner.tools.importing.mapping import Part
    from rigrunner.tools.importing.planning import PlannedImport
    from rigrunner.yamlfile.document import Path as DocumentPath

BLOCK_SAMPLES = 1 << 16
_DAY = timedelta(days=1)
_SECOND = timedelta(seconds=1)
_LENGTH_TOLERANCE = 1e-3
"""Relative: a recording that is shorter than planned by less is complete."""
_RATE_TOLERANCE = 0.01
"""Relative: sampling rates that differ by less are one nominal rate, of two clocks."""


def write_run(
    checked: PlannedImport,
    sinks: Sequence[EventSink],
    run_id: str,
    overrides: Sequence[Override],
    progress: Progress,
) -> None:
    """Read all recordings, one after the other, and send their events to the sinks.

    Raises InvalidFileError and DataError, as `read_part`, and if a value is out of its limits.
    """
    _Import(checked, sinks, progress).write(run_id, overrides)


class _Import:
    def __init__(
        self, checked: PlannedImport, sinks: Sequence[EventSink], progress: Progress
    ) -> None:
        self._checked = checked
        self._mapping = checked.mapping.model
        self._sinks = sinks
        self._progress = progress
        self._done = 0
        self._measurements = iter(self._mapping.measurements)
        self._zeros = {
            member: iter(self._mapping.zeros_of(member)) for member in self._mapping.zeros
        }
        self._seq = 0
        self._started = self._mapping.started.astimezone(UTC)
        self._latest = self._started

    def write(self, run_id: str, overrides: Sequence[Override]) -> None:
        plan = self._checked.planned.plan
        matched = self._checked.matched.recordings
        emit = self._emit_at(self._started)
        emit(RunStarted, run_id=run_id, steps=len(plan.steps), estimated_s=plan.estimated_s)
        for override in overrides:
            emit(
                Intervention,
                action="override",
                by=override.by,
                reason=override.reason,
                subject=override.subject,
            )
        mapping, reader = self._mapping, self._checked.reader
        files = len({recording.file for recording in mapping.recordings})
        origin = (
            f"Imported: {mapping.program} made the recordings, not Rigrunner; {reader}"
            f" read them from {files} file{'s' if files > 1 else ''}."
        )
        stated = (
            f"Set-points, conditions, single values, zeros and times are as {mapping.by} states"
            " them. That the other steps of the procedure were done, and the rig was safe,"
            " Rigrunner has not seen."
        )
        for text in (origin, stated):
            emit(Note, step="import", text=text)
        for index, step in enumerate(plan.steps):
            if isinstance(step.action, Zero):
                self._zero(index, step, step.action)
            elif isinstance(step.action, Measure):
                result = StepResult(self._next_values(), step.action.units, {})
                self._step(index, step, (self._latest, self._latest), result)
            elif isinstance(step.action, Scan):
                self._scan(index, step, step.action)
            elif isinstance(step.action, Record):
                self._record(index, step, step.action, matched[index])
        self._emit_at(self._end_time())(RunEnded, outcome=Outcome.COMPLETED)

    def _zero(self, index: int, step: PlannedStep, action: Zero) -> None:
        member = action.zeroed
        at, zero = next(self._zeros[member])
        if isinstance(zero, Quantity):
            value, scatter = zero.si, (0.0, 0.0)
        else:  # a recording at rest
            column = MappedColumn(self._mapping.channels[member], ("channels", member))
            checked = self._checked
            data = read_part(checked.mapping, checked.importer, zero, at, {member: column})
            value = float(data.columns[member].mean())
            scatter = scatter_of_mean(data.columns[member])
        if abs(value) > action.within:
            message = (
                f"{member} read {value:.4g} {action.unit} at rest,"
                f" more than the {action.within:g} {action.unit} that the procedure allows"
            )
            raise fault(self._checked.mapping, at, message)
        result = StepResult({member: value}, {member: action.unit}, scatter={member: scatter})
        self._step(index, step, (self._latest, self._latest), result)

    def _next_values(self) -> dict[str, float]:
        """Return the next stated values."""
        return {member: quantity.si for member, quantity in next(self._measurements).values.items()}

    def _scan(self, index: int, step: PlannedStep, action: Scan) -> None:
        attempt, emit = Attempt(index, step, 1, 1), self._emit_at(self._latest)
        attempt.begin(emit)
        for point, value in enumerate(action.values):
            values = self._next_values()
            emit(
                Scanned,
                step=step.path,
                point=point,
                measurement=action.name,
                setpoints={**action.setpoints, action.moves: value},
                values=values,
            )
            for kind, text in remarks_on(action.limits, values, partial(action.where, point)):
                emit(kind, step=step.path, text=text)
        attempt.end(emit, ok=True)

    def _record(self, index: int, step: PlannedStep, action: Record, number: int) -> None:
        entry, at = self._mapping.recordings[number], ("recordings", number)
        members = [Member(action.role, name) for name in action.channels]
        conditions = {**self._mapping.conditions, **entry.conditions}
        mapped: dict[str, MappedColumn] = {
            member: MappedColumn(self._mapping.channels[member], ("channels", member))
            for member in members
        }
        for name, condition in conditions.items():
            if isinstance(condition, ColumnSpec):
                base = (*at, "conditions") if name in entry.conditions else ("conditions",)
                mapped[name] = MappedColumn(condition, (*base, name))
        data = read_part(self._checked.mapping, self._checked.importer, entry, at, mapped)
        samples: dict[str, Array] = {member: data.columns[member] for member in members}
        length_s = len(samples[members[0]]) / data.rate_hz
        if length_s < action.duration_s * (1 - _LENGTH_TOLERANCE):
            beginning = (
                "; a recording may begin anywhere in a cycle, so it needs one cycle more than is"
                " counted"
                if action.cycle_frequency_hz
                else ""
            )
            raise DataError(
                f"the recording is only {length_s:.6g} s long; asked for is: {step.text}",
                location=Location(str(self._checked.mapping.file(entry.file))),
                hint="use a procedure that matches the recording" + beginning,
            )
        planned_hz = action.sample_rate_hz
        if planned_hz and abs(data.rate_hz - planned_hz) > _RATE_TOLERANCE * planned_hz:
            raise DataError(
                f"the recording has {data.rate_hz:.6g} samples per second, the station states"
                f" {planned_hz:.6g} for '{action.role}'",
                location=Location(str(self._checked.mapping.file(entry.file))),
                hint="correct the rate in the station: the procedure is checked with it",
            )
        values, units = _conditions(conditions, data)
        available = {*values, *action.statistics}
        if unstated := [limit.of for limit in step.terms.limits if limit.of not in available]:
            message = f"{unstated[0]} is not stated, and the procedure has limits for it"
            raise fault(self._checked.mapping, at, message, "state it under 'conditions'")
        started = self._start_of(entry, at, data)
        ended = started + timedelta(seconds=length_s)
        statistics = RecordedStatistics(action.statistics)
        statistics.take(samples)
        result = StepResult(values, {**action.units, **units}, {}, statistics.by_name())
        self._step(index, step, (started, ended), result, replace(data, columns=samples))
        self._latest = max(self._latest, ended)
        self._done += 1
        self._progress("recordings", self._done, len(self._mapping.recordings))

    def _start_of(self, part: Part, at: DocumentPath, data: RecordingData) -> datetime:
        """Return when a recording began: from the file, or else after the one before."""
        if data.started is None:
            return self._latest
        local = self._mapping.started.tzinfo
        file_time = data.started if data.started.tzinfo else data.started.replace(tzinfo=local)
        began = file_time.astimezone(UTC) + timedelta(seconds=part.from_ or 0.0)
        latest = (self._mapping.ended or self._mapping.started + _DAY).astimezone(UTC)
        if not self._started - _DAY <= began <= latest + _DAY:
            raise fault(
                self._checked.mapping,
                (*at, "file"),
                f"the file says that it was recorded at {utc_text(began)}, but the run is said to"
                f" have been started at {utc_text(self._started)}",
                "correct 'started', or give 'ended' for a run of more than a day",
            )
        return began

    def _end_time(self) -> datetime:
        stated = self._mapping.ended
        if stated is None:
            return self._latest
        if self._latest > stated.astimezone(UTC) + _SECOND:
            message = f"the last recording ends at {utc_text(self._latest)}, which is later"
            raise fault(self._checked.mapping, ("ended",), message)
        return stated.astimezone(UTC)

    def _step(
        self,
        index: int,
        step: PlannedStep,
        times: tuple[datetime, datetime],
        result: StepResult,
        data: RecordingData | None = None,
    ) -> None:
        attempt, (started, ended) = Attempt(index, step, 1, 1), times
        attempt.begin(self._emit_at(started))
        if data is not None:
            count = len(next(iter(data.columns.values())))
            for first in range(0, count, BLOCK_SAMPLES):
                part = {
                    key: values[first : first + BLOCK_SAMPLES]
                    for key, values in data.columns.items()
                }
                began_s = self._monotonic_s(started) + first / data.rate_hz
                block = Block(data.rate_hz, first, began_s, part)
                self._emit_at(started)(Samples, recording=attempt.recording, block=block)
        emit = self._emit_at(ended)
        attempt.end(emit, result, ok=True)
        values = {**result.values, **result.statistics}
        for kind, text in remarks_on(step.terms.limits, values):
            emit(kind, step=step.path, text=text)

    def _emit_at(self, at: datetime) -> Emit:
        """Return a function that sends events of that time."""
        monotonic_s, utc = self._monotonic_s(at), utc_text(at)

        def emit(kind: type[Event], /, **fields: Any) -> None:
            event = kind(seq=self._seq, monotonic_s=monotonic_s, utc=utc, **fields)
            self._seq += 1
            for sink in self._sinks:
                sink(event)

        return emit

    def _monotonic_s(self, at: datetime) -> float:
        return (at - self._started).total_seconds()


def _conditions(
    conditions: Mapping[Member, Quantity | ColumnSpec], data: RecordingData
) -> tuple[dict[str, float], dict[str, str]]:
    """Return values and units in SI: a stated value, or the mean of its column."""
    values: dict[str, float] = {}
    units: dict[str, str] = {}
    for name, condition in conditions.items():
        if isinstance(condition, ColumnSpec):
            values[name], source = float(data.columns[name].mean()), unit(condition.unit)
        else:
            values[name], source = condition.si, condition.unit
        units[name] = si_symbol(source.dimension)
    return values, units
