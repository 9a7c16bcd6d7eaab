"""Whether the item conforms, and by which rule that was decided."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, JsonValue, model_validator

from rigrunner.api.certificate.part import Part, Sha256, Text
from rigrunner.api.certificate.results import CoordinatePart

_OLDER = {"lower_nm": "lower", "upper_nm": "upper", "guard_band_nm": "guard_band"}
"""Members of documents from before limits had units: there every limit was one of a torque."""


class LimitStatement(Part):
    """What one limit says of one result."""

    of: Text
    """What is judged: 'mean', one set-point such as '35 Hz', or a named result and its place."""
    named: str = ""
    """The name of the result; empty in documents from before the torque had one."""
    coordinates: dict[str, CoordinatePart] = Field({})
    """Where the result holds; empty of a mean, and of the only result of its name."""
    printed_result: str = ""
    """With its expanded uncertainty and unit; empty in older documents."""
    unit: str = "N·m"
    """Of limits and guard band."""
    verdict: Text
    reason: Text
    """In a sentence, as the run has it."""
    limit: Text
    """As '≤ 0.95 N·m'."""
    lower: float | None
    upper: float | None
    source: Text
    """The specification."""
    measurand: str = ""
    """Of what the limit is a limit, as the specification has it; empty where it does not say."""
    load_n: float | None = None
    """The load that the limit is for, where it names one."""
    guard_band: float | None = None
    printed_guard_band: str = ""
    """With its unit."""
    stated_risk: float | None = None
    """The highest probability that an item which the rule passes does not conform (JCGM 106)."""
    probability_of_conformity: float | None
    printed_probability: str = ""
    """In per cent."""
    uncompensated: str
    """What the same rule would say of the raw torque; empty of another quantity."""
    marginal: bool = False
    """Whether a result different by no more than the marginal band had another verdict."""

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, value: object) -> object:
        if not isinstance(value, dict):
            return value
        return {_OLDER.get(name, name): item for name, item in value.items()}


class DecisionRecord(Part):
    """A decision by which a stored run was decided again, as it is on record beside the run."""

    file: Text
    sha256: Sha256
    """Of that file's bytes."""
    decided_utc: Text
    by: Text
    reason: Text
    """Why it was decided again."""
    verdict: Text
    rule: Text
    """As 'name: the rule in words'."""
    limit: Text
    verdict_before: Text
    """What held until then; 'none' where nothing had been decided."""
    rule_before: Text
    limit_before: Text
    acceptance: dict[str, JsonValue]
    """Limits and rule, as a procedure writes them: by these the verdict can be derived again."""


class Conformity(Part):
    """The statement of conformity with its decision rule (7.8.6)."""

    verdict: Text
    rule: Text
    """The rule's name, as in the procedure."""
    rule_words: str
    """The rule in words, as the run has it."""
    rule_words_in: dict[str, str] = Field({})
    """The same in other languages than English, where the rule has them."""
    statements: Annotated[tuple[LimitStatement, ...], Field(min_length=1)]
    """Of every limit, the one that decides first."""
    decided_again: tuple[DecisionRecord, ...] = ()
    """Decisions after the run's own, oldest first: what is stated here is by the last of them."""
