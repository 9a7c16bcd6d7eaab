"""The statement of conformity and its decision rule."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, JsonValue, model_validator

from rigrunner.api.certificate.part import Part, Sha256, Text
from rigrunner.api.certificate.results import CoordinatePart

_OLDER = {"lower_nm": "lower", "upper_nm": "upper", "guard_band_nm": "guard_band"}
"""Members of documents of 0.1.0, in which every limit was one of a torque, without a unit."""


class LimitStatement(Part):
    """The decision on one result by one limit."""

    of: Text
    """What the limit applies to: 'mean', one set-point, such as '35 Hz', or a named result."""
    named: str = ""
    """Name of the result; empty in older documents."""
    coordinates: dict[str, CoordinatePart] = Field({})
    """Place of the result; empty for a mean, and for the only result of its name."""
    printed_result: str = ""
    """The result with expanded uncertainty and unit; empty in older documents."""
    unit: str = "N·m"
    """Unit of limits and guard band."""
    verdict: Text
    reason: Text
    """One sentence, from the run."""
    limit: Text
    """The limit as text: '≤ 0.95 N·m'."""
    lower: float | None
    upper: float | None
    source: Text
    """Source of the limit: the specification."""
    measurand: str = ""
    """The measurand of the limit by the specification; empty if not stated."""
    load_n: float | None = None
    """The load for which the limit is stated, if any."""
    guard_band: float | None = None
    printed_guard_band: str = ""
    """With its unit."""
    stated_risk: float | None = None
    """The highest probability that an item which the rule passes does not conform (JCGM 106)."""
    probability_of_conformity: float | None
    printed_probability: str = ""
    """The probability in per cent."""
    uncompensated: str
    """The verdict of the same rule on the uncorrected value; empty if there is none."""
    marginal: bool = False
    """Whether a change of the result within the marginal band would change the verdict."""

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, value: object) -> object:
        if not isinstance(value, dict):
            return value
        return {_OLDER.get(name, name): item for name, item in value.items()}


class DecisionRecord(Part):
    """A later decision on a stored run, as recorded beside it."""

    file: Text
    sha256: Sha256
    """SHA-256 of the bytes of the record."""
    decided_utc: Text
    by: Text
    reason: Text
    """The stated reason for the new decision."""
    verdict: Text
    rule: Text
    """Name and description: 'simple: ...'."""
    limit: Text
    verdict_before: Text
    """The verdict until then; 'none' without one."""
    rule_before: Text
    limit_before: Text
    acceptance: dict[str, JsonValue]
    """Limits and rule as in a procedure: the verdict can be derived again from them."""


class Conformity(Part):
    """The statement of conformity with its decision rule (7.8.6)."""

    verdict: Text
    rule: Text
    """Name of the rule in the procedure."""
    rule_words: str
    """Description of the rule, from the run."""
    rule_words_in: dict[str, str] = Field({})
    """The description in other languages than English, if available."""
    statements: Annotated[tuple[LimitStatement, ...], Field(min_length=1)]
    """A statement for each limit, the deciding one first."""
    decided_again: tuple[DecisionRecord, ...] = ()
    """Later decisions, oldest first; the last of them is stated here."""
