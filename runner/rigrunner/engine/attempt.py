"""One attempt of a step: its events, and the consequence of a failure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, DeviceError
from rigrunner.api.events import StepEnded, StepStarted
from rigrunner.api.steps import NONE, NOTHING

if TYPE_CHECKING:
    from rigrunner.api.steps import StepResult
    from rigrunner.bus import Emit
    from rigrunner.plan.actions import PlannedStep
    from rigrunner.rig.cycles import CycleCount


class Attempt:
    """The number of the attempt, from 1, of a step of the plan.

    `total` is its number over all attempts, if the step was repeated.
    """

    def __init__(
        self,
        index: int,
        step: PlannedStep,
        number: int,
        total: int,
        cycles: CycleCount | None = None,
    ) -> None:
        """Record the cycles too, if a rig moves."""
        self.step = step
        self.number = number
        self.action = step.action.for_attempt(total)
        self.recording = self.action.recording
        self._index = index
        self._table = self.action.table
        self._setpoints, self._units = self.action.setpoints_and_units
        self._cycles = cycles

    def begin(self, emit: Emit) -> None:
        """Record its start; for a step that reads, with the number of cycles."""
        emit(
            StepStarted,
            step=self.step.path,
            index=self._index,
            action=self.action.kind,
            text=self.step.text,
            recording=self.recording,
            setpoints=self._setpoints,
            units={**self._units, **self.step.coordinate_units},
            limits=self.step.limits,
            coordinates=self.step.coordinates,
            written_in=self.step.written_in,
            expected=self.step.terms.expected,
            cycles=self._cycles.done() if self._cycles and self.action.reads else NONE,
        )

    def end(self, emit: Emit, result: StepResult = NOTHING, *, ok: bool) -> None:
        """Record its end and its result."""
        emit(
            StepEnded,
            step=self.step.path,
            index=self._index,
            action=self.action.kind,
            ok=ok,
            recording=self.recording,
            measurement=self._table,
            # A row of a table is stored with them; a recording has those of its start.
            setpoints=self._setpoints if self._table else NONE,
            values=result.values,
            statistics=result.statistics,
            units=result.units,
            readings=result.readings,
            leaves=self.step.leaves if result.leaves else 0,
            cycles=self._cycles.done() if self._cycles else NONE,
            truth=result.truth if ok else NONE,
            scatter=result.scatter,
        )

    def may_retry(self, error: BaseException) -> bool:
        """Return whether another attempt follows this error."""
        return _is_failure(error) and self.number < self.step.terms.attempts

    def may_continue(self, error: BaseException) -> bool:
        """Return whether the run continues despite this error."""
        return _is_failure(error) and self.step.terms.continues


def _is_failure(error: BaseException) -> bool:
    """Return whether the step failed; a person, a sink or a bug ends the run instead."""
    return isinstance(error, (DeviceError, DataError))
