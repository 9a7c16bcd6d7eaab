"""The built-in decision rules: simple acceptance, guard bands, and a non-binary statement.

JCGM 106:2012, 8, and ILAC-G8:09/2019, 4.2. Does not import scipy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from rigrunner.api import DecisionRuleRecord, NoSettings, Settings, Verdict, Zone, hookimpl

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import Estimate, Limits


class FractionSettings(Settings):
    """Settings of the rule `guard_band_fraction`."""

    fraction: Annotated[float, Field(gt=0, le=5, description="share of U: w = fraction · U")]


@dataclass(frozen=True)
class Simple:
    """Simple acceptance (ILAC-G8, 4.2.1); implements `rigrunner.api.verdict.DecisionRule`."""

    settings: NoSettings

    @property
    def words(self) -> Mapping[str, str]:
        """A description of the rule."""
        return {"en": "simple acceptance, the value alone decides (w = 0)"}

    def __call__(self, limits: Limits, estimate: Estimate) -> Sequence[Zone]:  # noqa: ARG002  (the same for all)
        """Return the pass zone: all that is within the limits."""
        return [Zone(Verdict.PASS, 0.0)]


@dataclass(frozen=True)
class GuardBand:
    """Binary statement with a guard band (ILAC-G8, 4.2.2)."""

    share: float = 1.0
    """The guard band w as a share of U."""
    guard: str = "U"
    """The guard band w in words."""

    @classmethod
    def of_fraction(cls, settings: FractionSettings) -> GuardBand:
        """Return the rule with the guard band from its settings."""
        return cls(settings.fraction, f"{settings.fraction:g} U")

    @property
    def words(self) -> Mapping[str, str]:
        """A description of the rule."""
        return {
            "en": f"guard band w = {self.guard} of 95 %; what is not within the limit by w fails"
        }

    def __call__(self, limits: Limits, estimate: Estimate) -> Sequence[Zone]:  # noqa: ARG002  (the same for all)
        """Return the pass zone."""
        width = "U" if self.share == 1 else f"w = {self.guard}"
        return [Zone(Verdict.PASS, self.share * _expanded(estimate), width)]


@dataclass(frozen=True)
class NonBinary:
    """Conditional verdicts in a guard band on both sides of the limit (ILAC-G8, 4.2.3)."""

    settings: NoSettings

    @property
    def words(self) -> Mapping[str, str]:
        """A description of the rule."""
        return {"en": "guard band w = U of 95 %; what is nearer to the limit than w is conditional"}

    def __call__(self, limits: Limits, estimate: Estimate) -> Sequence[Zone]:  # noqa: ARG002  (the same for all)
        """Return the three zones; beyond them is a fail."""
        guard = _expanded(estimate)
        return [
            Zone(Verdict.PASS, guard, "U"),
            Zone(Verdict.CONDITIONAL_PASS, 0.0),
            Zone(Verdict.CONDITIONAL_FAIL, -guard, "U"),
        ]


@hookimpl
def rigrunner_decision_rules() -> list[DecisionRuleRecord]:
    """Return the decision rules."""
    return [
        DecisionRuleRecord(
            name="simple",
            help="Simple acceptance: the value alone decides (w = 0)",
            factory=Simple,
        ),
        DecisionRuleRecord(
            name="guard_band_u",
            help="Pass if the value is within the limit by at least U, else fail",
            factory=lambda _: GuardBand(),
        ),
        DecisionRuleRecord(
            name="guard_band_fraction",
            help="Pass if the value is within the limit by at least a fraction of U, else fail",
            settings=FractionSettings,
            factory=GuardBand.of_fraction,
            trial={"fraction": 0.5},
        ),
        DecisionRuleRecord(
            name="non_binary",
            help="Pass and fail by U; nearer to the limit conditional pass or fail",
            factory=NonBinary,
        ),
    ]


def _expanded(estimate: Estimate) -> float:
    from rigrunner.signal.coverage import expanded  # noqa: PLC0415  (scipy)

    return expanded(estimate)
