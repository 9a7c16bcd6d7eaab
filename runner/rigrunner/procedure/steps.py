"""The steps of a procedure: each a mapping with one key, which names its kind."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pydantic_core import core_schema

from rigrunner.api.errors import did_you_mean
from rigrunner.api.hooks import StepRecord
from rigrunner.api.steps import StepSettings
from rigrunner.procedure.kinds import KINDS, STORED, installed_kinds, read_with_key
from rigrunner.procedure.refusals import refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic import BaseModel, GetCoreSchemaHandler

    from rigrunner.api.steps import Planning

Scalar = str | bool | int | float
Parameter = Scalar | list[Scalar]


@dataclass(frozen=True)
class Step:
    """One step: its kind and its settings."""

    kind: str
    settings: StepSettings
    record: StepRecord = field(compare=False, repr=False)

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps within it."""
        return getattr(self.settings, "steps", ())

    @classmethod
    def inside(cls, kind: str) -> type[BaseModel] | None:
        """Return the model under a key that names a kind; None for any other."""
        record = installed_kinds().steps.get(kind)
        return None if record is None else record.steps_model

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Let a model read it, by the kinds in the context of the validation."""
        return core_schema.with_info_plain_validator_function(_read)


def _refuse(settings: StepSettings, planning: Planning) -> None:  # noqa: ARG001  (not known)
    """Refuse to plan a step whose kind is not installed here."""
    planning.complain((), "the kind of this step is not installed here")


_MISSING = StepRecord(name="missing", help="", settings=StepSettings, factory=_refuse)


def _read(value: Any, info: core_schema.ValidationInfo) -> Step:
    if isinstance(value, Step):
        return value
    context = info.context or {}
    kinds: Mapping[str, StepRecord] = (context.get(KINDS) or installed_kinds()).steps
    # Of a stored run only the analysis is needed: a kind that is not installed is kept unread.
    if context.get(STORED) and isinstance(value, dict) and not value.keys() & kinds.keys():
        return Step(next(iter(value)), StepSettings(), _MISSING)
    kind = _known_key(value, kinds)
    record = kinds[kind]
    return Step(kind, read_with_key(kind, record.steps_model, value[kind], context), record)


def _known_key(value: object, kinds: Mapping[str, object]) -> str:
    """Return the one key; refuse what is no mapping with one key that names a kind."""
    expected = f"expected one of: {', '.join(kinds)}"
    if not isinstance(value, dict):
        raise refusal(f"a step is a mapping with one key, such as 'settle: ...'; {expected}")
    keys = [str(key) for key in value]
    if len(keys) != 1:
        got = " and ".join(f"'{key}'" for key in keys[:5]) or "none"
        hint = "begin each step with its own '-'" if keys else ""
        raise refusal(f"a step has one key, got {got}; {expected}", hint)
    if keys[0] not in kinds:
        raise refusal(f"unknown step '{keys[0][:40]}'; {expected}", did_you_mean(keys[0], kinds))
    return keys[0]
