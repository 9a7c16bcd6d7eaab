"""What is acceptable: limits of results, and the rule by which they are applied."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api.plugin_refs import PluginRef
from rigrunner.api.settings import Difference, ListOf, Settings
from rigrunner.procedure.kinds import ASKED, KINDS, STORED
from rigrunner.procedure.result_limits import Limit

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.procedure.analyses import AnalysisRef
    from rigrunner.procedure.kinds import Kinds


class DecisionRuleRef(PluginRef):
    """A decision rule: by its name, or as `name: {setting: value}`."""

    kind = "decision_rule"

    def as_written(self) -> str | dict[str, object]:
        """Return it as a file has it; read back, it is the same."""
        return {self.name: dict(self.settings)} if self.settings else self.name


class Acceptance(Settings):
    """Limits and decision rule, agreed before the measurement."""

    limits: Annotated[ListOf[Limit], Field(min_length=1)]
    """Limits of results, by their names."""
    rule: Annotated[DecisionRuleRef, Field(validate_default=True)] = "simple"  # type: ignore[assignment]  # validated
    """Decision rule: the guard band, and the possible verdicts."""
    fraction: Annotated[float, Field(gt=0, le=5)] | None = None
    """The same as the setting `fraction` of the rule, such as of `guard_band_fraction`."""
    marginal: Difference | None = None
    """A verdict is marginal if a change of the result by this would change it; for results of this
    kind of quantity."""

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.fraction is not None and self.rule.settings:
            raise ValueError("write 'fraction' with the other settings of the rule")
        counts = Counter(limit.scope for limit in self.limits)
        repeated = [scope for scope, count in counts.items() if count > 1]
        if repeated:
            raise ValueError(f"there are two limits of {repeated[0]}")
        return self

    @property
    def rule_settings(self) -> dict[str, Any]:
        """The settings of the rule."""
        return {**self.rule.settings, **_without_none(fraction=self.fraction)}

    def limits_of(self, name: str) -> tuple[Limit, ...]:
        """Return the limits of the results of a name."""
        return tuple(limit for limit in self.limits if limit.of == name)

    def as_read_by(self, kinds: Kinds, analyses: Iterable[AnalysisRef]) -> Self:
        """Return it with its measurands as those analyses read them, or kept as written."""
        context = {KINDS: kinds, STORED: True, ASKED: [analysis.name for analysis in analyses]}
        return self.model_validate(self.as_written(), context=context)

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it, with units; read back, it is the same."""
        return {
            "limits": [limit.as_written() for limit in self.limits],
            "rule": self.rule.as_written(),
            **_without_none(
                fraction=self.fraction,
                marginal=None if self.marginal is None else str(self.marginal),
            ),
        }


class AcceptanceFile(Settings):
    """A file with limits and rule alone, to decide a stored run again."""

    rigrunner: Literal["acceptance/1"]
    """Type and version of this file."""
    acceptance: Acceptance


def _without_none(**values: object) -> dict[str, object]:
    return {name: value for name, value in values.items() if value is not None}
