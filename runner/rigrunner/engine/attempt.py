"""One try of a step: what its events say of it, and what its failure means."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, DeviceError
from rigrunner.engine.found import NONE, NOTHING
from rigrunner.engine.steps import action_name
from rigrunner.plan.actions import Measure, Record, Scan

if TYPE_CHECKING:
    from rigrunner.engine.found import Measured
    from rigrunner.plan.actions import PlannedStep


class Attempt:
    """The so-manieth try, from 1, of a step at its place in the plan.

    `total` is the so-manieth all in all, where the step was repeated.
    """

    def __init__(self, index: int, step: PlannedStep, number: int, total: int) -> None:
        self.step = step
        self.number = number
        self.action = action = step.action
        self.recording = self._measurement = ""
        self._index = index
        self._name = action_name(action)
        self._setpoints = self._units = NONE
        self._limits = step.limits
        if isinstance(action, Measure):
            self._measurement = action.name
            self._setpoints, self._units = action.setpoints, action.units
        elif isinstance(action, Record):
            if total > 1:  # each try makes a recording of its own
                self.action = action = replace(action, name=f"{action.name}_try{total}")
            self.recording = action.name
            self._setpoints, self._units = action.setpoints, action.units
        elif isinstance(action, Scan):
            self._setpoints, self._units = action.setpoints, action.units

    @property
    def reads(self) -> bool:
        """Whether the step reads what belongs to where the drives stand."""
        return isinstance(self.action, (Measure, Record, Scan))

    def started(self) -> dict[str, Any]:
        """Return all fields of its StepStarted, whose stamp is to be filled in."""
        return {
            "seq": 0,
            "monotonic_s": 0.0,
            "utc": "",
            "step": self.step.path,
            "index": self._index,
            "action": self._name,
            "text": self.step.text,
            "recording": self.recording,
            "setpoints": self._setpoints,
            "units": self._units,
            "limits": self._limits,
        }

    def ended(self, found: Measured = NOTHING, *, ok: bool) -> dict[str, Any]:
        """Return all fields of its StepEnded, whose stamp is to be filled in."""
        return {
            "seq": 0,
            "monotonic_s": 0.0,
            "utc": "",
            "step": self.step.path,
            "index": self._index,
            "action": self._name,
            "ok": ok,
            "recording": self.recording,
            "measurement": self._measurement,
            "setpoints": self._setpoints if self._measurement else NONE,
            "values": found.values,
            "statistics": found.statistics,
            "units": found.units,
            "truth": found.truth if ok else NONE,
        }

    def is_tried_again(self, error: BaseException) -> bool:
        """Say whether another try follows upon an error."""
        return _is_failure(error) and self.number < self.step.terms.tries

    def is_passed_over(self, error: BaseException) -> bool:
        """Say whether the run goes on in spite of an error."""
        return _is_failure(error) and self.step.terms.goes_on


def _is_failure(error: BaseException) -> bool:
    """Say whether a step failed, and not the run: a person, a sink or a bug ends that."""
    return isinstance(error, (DeviceError, DataError))
