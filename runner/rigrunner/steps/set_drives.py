"""`set`: drives are set, one after the other, and read back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, model_validator

from rigrunner.api.hooks import StepRecord
from rigrunner.api.member import Member
from rigrunner.api.settings import AnyQuantity
from rigrunner.api.steps import NONE, Action, StepResult, StepSettings
from rigrunner.procedure.options import Repeatable, Retries, Timeout

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    from rigrunner.engine.session import Session
    from rigrunner.plan.planning import Planning

_OPTIONS = ("label", "when", "timeout", "retries", "repeatable")


class SetStep(StepSettings):
    """Sets drives in the given order, and reads each back."""

    drives: Annotated[dict[Member, AnyQuantity], Field(min_length=1)]
    """Role and drive, such as tester.load; written beside the other keys."""
    timeout: Timeout = None
    retries: Retries = 0
    repeatable: Repeatable = True

    def actions(self) -> int:
        """Return the number of drives."""
        return len(self.drives)

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
        """Return the schema as written, with drives beside the options."""
        schema: dict[str, Any] = handler(core_schema)
        # In the file the drives are keys of the step itself, and `drives` is none.
        resolved = handler.resolve_ref_schema(schema)
        drives = resolved["properties"].pop("drives")
        resolved["patternProperties"] = drives["patternProperties"]
        resolved["minProperties"] = drives["minProperties"]
        resolved.pop("required", None)
        return schema


_member = cache(Member)
"""A sweep sets one drive many times."""


@dataclass(frozen=True, slots=True)
class SetDrive(Action):
    """Sets one drive, in its SI unit."""

    kind = "set"
    role: str
    drive: str
    value: float
    unit: str

    @property
    def moves(self) -> Member:
        """The drive."""
        return _member(self.role, self.drive)

    @property
    def moves_to(self) -> tuple[float]:
        """The set-point."""
        return (self.value,)

    def do(self, step: str, doing: Session) -> StepResult:  # noqa: ARG002  (its errors name the drive)
        """Set the drive: at once, or at the rate in the station."""
        doing.check()
        actual = doing.lead(self.role, self.drive, self.value)
        return StepResult({self.moves: actual}, {self.moves: self.unit}, NONE)


def plan(targets: SetStep, planning: Planning) -> None:
    """Plan the drives, one after the other."""
    for member, quantity in targets.drives.items():
        moved = planning.move(member, quantity, (member,), (member,))
        if moved is not None:
            action = SetDrive(member.role, member.name, quantity.si, moved[0])
            at, text = planning.place.inside(member), f"Set {member} to {quantity}"
            planning.emit(action, text, moved[1], at=at)


STEP = StepRecord(
    name="set",
    help="Sets drives in the given order, and reads each back.",
    settings=SetStep,
    factory=plan,
    example="set: {role.drive: 1000 N}",
    trial={"tester.load": "100 N"},
)
