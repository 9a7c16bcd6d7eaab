"""The results to decide on, and the reasons why nothing can be decided on them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Consequence
from rigrunner.api.checks import forbidden

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.analysis import Check
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.details import AnalysisDetails
    from rigrunner.api.findings import MeasurementResult, MissingResult
    from rigrunner.procedure import Limit


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """All results of a run to which limits may apply."""

    results: tuple[MeasurementResult, ...] = ()
    missing: tuple[MissingResult, ...] = ()
    """Places at which a result has no value."""
    means: tuple[MeasurementResult, ...] = ()
    """Of those results whose analysis gives their mean itself."""
    problems: Mapping[str, str] = field(default_factory=dict)
    """Why nothing can be decided on the results of a name, as a sentence; '' where it can."""
    checks: tuple[Check, ...] = ()
    """Checks of some results alone, as judged."""
    details: Mapping[str, AnalysisDetails] = field(default_factory=dict)
    """Details of the analysis of a result, by the result's name; not every analysis has them."""

    def problem(self, limit: Limit, coordinates: Mapping[str, CoordinateValue]) -> str:
        """Return why nothing can be decided on the result at a place, as a sentence; '' if it can.

        For a limit of a mean: on any result that enters it.
        """

        def is_about(check: Check) -> bool:
            places = [place for name, place in check.of if name == limit.of]
            return any(map(limit.is_of, places)) if limit.mean else coordinates in places

        checks = filter(is_about, self.checks)
        return self.problems.get(limit.of) or forbidden(checks)


def as_judged(check: Check) -> Check:
    """Return a check with its consequence; a decisive one that failed forbids to decide.

    Of others the analysis may have set the consequence; else they are notes.
    """
    if check.ok or (check.consequence and not check.decisive):
        return check
    consequence = Consequence.INCONCLUSIVE if check.decisive else Consequence.NOTE
    return replace(check, ok=not check.decisive, consequence=consequence)
