"""A decision rule as it is applied: verdict, reason, risks and marginality follow from its zones.

JCGM 106, 8, and ILAC-G8:09/2019, 4.2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from typing import TYPE_CHECKING

from rigrunner.api.units import of_difference, unit, with_symbol
from rigrunner.api.verdict import Verdict
from rigrunner.signal.coverage import expanded, probability_within
from rigrunner.signal.rounding import places, places_apart, places_of_margin, printed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner.analysis.scrutiny import Scrutiny
    from rigrunner.api.data import Estimate
    from rigrunner.api.quantity import Quantity
    from rigrunner.api.verdict import DecisionRule, Limits, Zone
    from rigrunner.procedure import Acceptance

ENGLISH = "en"
ROUNDING = 1e-9
"""A value that is off its limit by this share of u is on it: 25.05 °C, computed in K, is not."""


@dataclass(frozen=True)
class AppliedRule:
    """A rule with its name, and the band within which a verdict counts as marginal.

    Every method takes an estimate whose uncertainty is known and not zero.
    """

    name: str
    zones: DecisionRule
    marginal: Quantity | None = None
    """A verdict that so small a difference would change is marginal, in limits of its kind."""

    @classmethod
    def of(cls, acceptance: Acceptance, scrutiny: Scrutiny) -> AppliedRule:
        """Return the rule that a procedure names; raise PluginError."""
        name = acceptance.rule.name
        zones = scrutiny.make("decision_rule", name, acceptance.rule_settings)
        return cls(name, zones, acceptance.marginal)

    def __str__(self) -> str:
        """Return the rule's name and what it does."""
        return f"{self.name}: {self.zones.words[ENGLISH]}"

    @property
    def in_other_languages(self) -> Mapping[str, str]:
        """What it does, in the languages beside English that the rule knows."""
        return {name: text for name, text in self.zones.words.items() if name != ENGLISH}

    def guard(self, limits: Limits, estimate: Estimate) -> float:
        """Return w: a value passes that is within the limits by at least w; nan where none can."""
        first = self.zones(limits, estimate)[:1]
        return first[0].margin if first and first[0].verdict is Verdict.PASS else nan

    def verdict(self, limits: Limits, estimate: Estimate) -> tuple[Verdict, str]:
        """Return the verdict on a value, and why, in one sentence.

        Numbers have two digits of U, or as many as distinguish the distance from the limit from
        the width of a zone. A value in no zone fails. Inside limits that are so near to each other
        that no value could be in any zone, nothing is decided.
        """
        zones = self.zones(limits, estimate)
        margin = limits.margin(estimate.value)
        if abs(margin) <= ROUNDING * estimate.u:
            margin = 0.0
        decimals = places_of_margin(places(expanded(estimate)), limits.unit)
        decimals = max(places_apart(abs(margin), abs(zone.margin), decimals) for zone in zones)

        def shown(value: float) -> str:
            return with_symbol(printed(value, decimals), limits.unit)

        # `proof.compare` knows the older words.
        place = f"Margin to the limit {limits}: {shown(abs(margin))}"
        if margin < 0:
            place = f"Outside the limit {limits} by {shown(abs(margin))}"
        # The index of the zone that the value is in; the number of zones if it is in none.
        reached = next((i for i, zone in enumerate(zones) if margin >= zone.margin), len(zones))
        if reached == len(zones) and margin >= 0 and not _reachable(zones, limits):
            width = _width(zones[-1], shown)
            why = f"the limits are too close for {width}, so no result can pass"
            return Verdict.INCONCLUSIVE, f"{place}; {why}."
        verdict = zones[reached].verdict if reached < len(zones) else Verdict.FAIL
        unproven = verdict is Verdict.FAIL and margin >= 0
        why = "; conformity is not demonstrated" if unproven else ""
        return verdict, f"{place}{_against(zones, reached, margin, shown)}{why}."

    def is_marginal(self, limits: Limits, estimate: Estimate) -> bool:
        """Return whether a value that differs by the marginal band or less had another verdict."""
        band, limit_unit = self.marginal, unit(limits.unit)
        kinds = {limit_unit.dimension, of_difference(limit_unit.dimension)}
        if band is None or band.dimension not in kinds:
            return False
        margin = limits.margin(estimate.value)
        distances = (abs(margin - zone.margin) for zone in self.zones(limits, estimate))
        return min(distances) <= band.si / limit_unit.factor  # a difference: no offset

    def false_accept_risk(self, limits: Limits, estimate: Estimate) -> float:
        """Return the highest probability that an item with this uncertainty passes wrongly.

        Specific consumer's risk (JCGM 106, 3.3.13) at the acceptance limit, where it is greatest;
        nan where the guard bands leave no value that could pass.
        """
        guard = self.guard(limits, estimate)
        if not limits.can_be_within(guard):
            return nan
        return max(1 - _conforming(limits, estimate, edge) for edge in limits.edges(guard))

    def false_reject_risk(self, limits: Limits, estimate: Estimate) -> float:
        """Return the highest probability that an item with this uncertainty fails wrongly.

        Specific producer's risk (JCGM 106, 3.3.14) where failing begins: beyond the last zone.
        """
        zones = self.zones(limits, estimate)
        # Where no value can reach a zone, nothing inside is decided: failing begins at the limit.
        begins = zones[-1].margin if _reachable(zones, limits) else 0.0
        return max(_conforming(limits, estimate, edge) for edge in limits.edges(begins))


def _reachable(zones: Sequence[Zone], limits: Limits) -> bool:
    return limits.can_be_within(zones[-1].margin)


def _against(
    zones: Sequence[Zone], reached: int, margin: float, shown: Callable[[float], str]
) -> str:
    """Return how the distance from the limit compares with the widths of the zones."""
    if margin >= 0:
        if reached:
            return f", less than {_width(zones[reached - 1], shown)}"
        return f" ({_width(zones[0], shown)})" if zones[0].margin > 0 else ""
    if reached < len(zones):
        return f", no more than {_width(zones[reached], shown)}"
    return f", more than {_width(zones[-1], shown)}" if zones[-1].margin < 0 else ""


def _width(zone: Zone, shown: Callable[[float], str]) -> str:
    return f"{zone.width} = {shown(abs(zone.margin))}"


def _conforming(limits: Limits, estimate: Estimate, value: float) -> float:
    return probability_within(limits, replace(estimate, value=value))
