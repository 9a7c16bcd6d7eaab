"""`call`: the steps of another procedure are executed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field

from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Name, Text
from rigrunner.api.steps import StepSettings
from rigrunner.procedure.steps import Parameter

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.plan.planning import Planning


class CallStep(StepSettings):
    """Executes another procedure: its setup, main and teardown."""

    procedure: Text
    """The file, in the folder of this one or below."""
    with_: Annotated[dict[Name, Parameter], Field(alias="with", default_factory=dict)]
    """Values of its parameters, in place of its own."""

    def actions(self) -> int:
        """Return 0: it has only the actions of the other procedure."""
        return 0

    def calls(self) -> tuple[str, Mapping[str, Any]]:
        """Return the file and its parameters."""
        return self.procedure, self.with_


def plan(call: CallStep, planning: Planning) -> None:  # noqa: ARG001  (the file is loaded already)
    """Plan the other procedure."""
    planning.walker.call(planning.place)


STEP = StepRecord(
    name="call",
    help="Executes another procedure: its setup, main and teardown.",
    settings=CallStep,
    factory=plan,
    example="call: {procedure: file.yaml, with: {name: value}}",
    trial={"procedure": "other.yaml"},
)
