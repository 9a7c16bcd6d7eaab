"""One try of a step: what its events say of it, and what its failure means."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import DataError, DeviceError
from rigrunner.engine.steps import action_name
from rigrunner.plan.actions import Measure, Record

if TYPE_CHECKING:
    from rigrunner.plan.actions import PlannedStep


class Attempt:
    """The so-manieth try, from 1, of a step at its place in the plan.

    `total` is the so-manieth all in all, where the step was repeated.
    """

    def __init__(self, index: int, step: PlannedStep, number: int, total: int) -> None:
        self.step = step
        self.number = number
        action = step.action
        known: dict[str, Any] = {"step": step.path, "index": index, "action": action_name(action)}
        if isinstance(action, Record):
            if total > 1:  # each try makes a recording of its own
                action = replace(action, name=f"{action.name}_try{total}")
            known["recording"] = action.name
        self.action = action
        self._identity = known

    @property
    def started(self) -> dict[str, Any]:
        """The fields of its StepStarted."""
        action = self.action
        known = {**self._identity, "text": self.step.text}
        if isinstance(action, (Measure, Record)):
            known["setpoints"], known["units"] = action.setpoints, action.units
        return known

    @property
    def ended(self) -> dict[str, Any]:
        """The fields of its StepEnded that do not depend on how it went."""
        action = self.action
        if isinstance(action, Measure):
            measured = {"measurement": action.name, "setpoints": action.setpoints}
            return {**self._identity, **measured}
        return self._identity

    def is_tried_again(self, error: BaseException) -> bool:
        """Say whether another try follows upon an error."""
        return _is_failure(error) and self.number < self.step.terms.tries

    def is_passed_over(self, error: BaseException) -> bool:
        """Say whether the run goes on in spite of an error."""
        return _is_failure(error) and self.step.terms.goes_on


def _is_failure(error: BaseException) -> bool:
    """Say whether a step failed, and not the run: a person, a sink or a bug ends that."""
    return isinstance(error, (DeviceError, DataError))
