"""What the analysis of torque keeps beside its results."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api import AnalysisDetails
from rigrunner_bearings.api.measurand import LimitMeasurand

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import Check, Component, Curve, Estimate, Points
    from rigrunner.api.measurands import LimitedMeasurand
    from rigrunner.api.results import Result
    from rigrunner_bearings.api.compensations import Compensation
    from rigrunner_bearings.api.measurand import MeasurandKind
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.validation import Validation

DRIFT_LINE = "drift of the support between the runs"
"""The line of a budget for what the support's friction changes by in between. Its source may follow
in parentheses."""
SUPPORT_LINE = "support friction under load"
"""The line of a budget for what the load may change the support's friction by.

Its source may follow in parentheses.
"""


@dataclass(frozen=True, eq=False)
class FittedTorque:
    """A fit of the no-load peaks over frequency, by its name in the procedure."""

    name: str
    points: Points
    curve: Curve | None
    problem: str = ""
    """Why the fit could not be made."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TorqueDetails(AnalysisDetails):
    """The recordings as they were prepared, and each method with what it gave."""

    name: str = "torque"
    """By which limits name the compensated torque."""
    loaded: tuple[PeakPoint, ...] = ()
    """The points of this run; of a no-load run, its own."""
    no_load: tuple[PeakPoint, ...] = ()
    fits: tuple[FittedTorque, ...] = ()
    compensations: Mapping[str, Compensation] = field(default_factory=dict)
    primary: str = ""
    """The compensation that the headline and the verdict use; '' for none."""
    kind: MeasurandKind | None = None
    """Which torque the primary method yields of what was recorded; None where it does not say."""
    headline: Estimate | None = None
    """The mean over the set-points by the primary method."""
    headline_components: tuple[Component, ...] = ()
    """Its budget: what the points have in common enters once, the rest averaged."""
    raw_headline: Estimate | None = None
    """The same mean of the raw torque."""
    validation: Validation | None = None
    """The Monte Carlo check of the headline, where the procedure asks for one."""
    problem: str = ""
    """Why there is no headline though one was asked for; '' where there is one."""
    forbids: str = ""
    """Why nothing can be decided on the torque, as a sentence; '' where it can."""

    @classmethod
    def of(cls, result: Result) -> TorqueDetails:
        """Return those of a result; empty ones where no torque was analysed."""
        return result.details_of(cls) or cls()

    @property
    def shown_results(self) -> frozenset[str]:
        """The compensated torque at its set-points."""
        return frozenset({self.name} if self.compensations else ())

    @property
    def corrects(self) -> bool:
        """By what the rig itself puts on the sensor."""
        return True

    @property
    def undecided(self) -> str:
        """What the checks say, and values without scatter."""
        return self.forbids

    def objection(self, limited: LimitedMeasurand | None) -> str:
        """Return why it is another torque than the limit's, or which one is not known."""
        if limited is None:
            return "The limit does not say of which torque it is: it needs a 'measurand'."
        if self.kind is None:
            return (
                f"{self.primary} does not say which torque it yields, and the limit is for the "
                f"{limited}."
            )
        if isinstance(limited, LimitMeasurand):
            why = limited.objection(self.kind, [point.load_n for point in self.loaded])
        else:
            why = limited.objection(self.kind)
        return f"{why[:1].upper()}{why[1:]}: conformity cannot be stated." if why else ""

    def impossible(self, value: float, unit: str) -> str:
        """Return why a value that is not above zero, or no number, is no friction torque."""
        if value > 0:
            return ""
        return f"{value:.4f} {unit} is not a friction torque: friction does not drive."

    @property
    def shows_recordings(self) -> bool:
        """Where there are points of them."""
        return bool(self.loaded)

    @property
    def checks_by_method(self) -> Mapping[str, tuple[Check, ...]]:
        """Those of each compensation."""
        return {name: compensation.checks for name, compensation in self.compensations.items()}

    @property
    def method_checks(self) -> tuple[Check, ...]:
        """Those of the primary method."""
        return self.checks_by_method.get(self.primary, ())

    @property
    def support_allowance(self) -> tuple[float, str] | None:
        """The most by which the load may raise the support's friction, and '%' or 'mN·m'.

        None where the budget has no line of it.
        """
        for component in self.headline_components:
            if component.name.startswith(SUPPORT_LINE):
                # A relative one is a limit: its rectangle ends at sqrt(3) u. A torque was
                # measured: its interval of about 95 % ends at 2 u.
                if component.unit == "1":
                    return 100 * (component.value + sqrt(3) * component.input_u), "%"
                return 1000 * (component.value + 2 * component.input_u), "mN·m"
        return None


def compensations_of(result: Result) -> Mapping[str, Compensation]:
    """Return the compensations of a result by name; none where no torque was analysed."""
    return TorqueDetails.of(result).compensations
