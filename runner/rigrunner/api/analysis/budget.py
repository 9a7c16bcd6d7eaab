"""Lines of uncertainty budgets, and checks of results, which may add one."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import hypot, nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.coordinates import CoordinateValue


@dataclass(frozen=True)
class Component:
    """One line of an uncertainty budget (GUM 8): an input and its contribution."""

    name: str
    u: float
    """Its contribution to that of the result, in the result's unit: |sensitivity| input_u."""
    dof: float
    distribution: str
    common: bool
    """True if the error is the same in all points of the run (it does not average out)."""
    value: float = nan
    """The input's estimate; nan where a line of several inputs has none."""
    unit: str = "N·m"
    """Of the input, `value` and `input_u`."""
    input_u: float = nan
    """The input's standard uncertainty."""
    sensitivity: float = nan
    """Sensitivity: change of the result per change of the input; 1 for a line of several inputs."""
    shared: bool = True
    """Whether a line of this name in another result is the same error. False of an error that may
    be another one at each reading: how much of it two results share is not stated."""
    at_place: bool = False
    """Whether a line of this name in another result at the same place is the same error: that of a
    result of which both are made."""
    of_points: str = ""
    """The points whose scatter it is, if results of the same points share it to an unknown extent.
    """


class Consequence(StrEnum):
    """What follows from a check."""

    NOTHING = ""
    NOTE = "note"
    """The finding has no relevant effect on a result."""
    BUDGET = "budget"
    """The finding has its own line in the uncertainty budget."""
    INCONCLUSIVE = "inconclusive"
    """No decision on the result is possible."""


@dataclass(frozen=True)
class Bias:
    """Bias of a result by the finding of a check, without correction (VIM 2.18)."""

    of: str
    """'mean', or the set-point: '35 Hz'."""
    value: float
    u: float
    unit: str = "N·m"

    @property
    def contribution(self) -> float:
        """The root mean square error of the result: a standard uncertainty."""
        return hypot(self.value, self.u)


@dataclass(frozen=True)
class Check:
    """A named check: its finding, its limit and its advice.

    A method states in `ok` whether the check passed, and in `biases` its effect on each point. The
    analysis decides the consequence; then `ok` is False only for a check with a consequence.
    """

    name: str
    ok: bool
    text: str
    advice: str = ""
    value: float | None = None
    """The finding, or the worst one; None if it is not a number."""
    threshold: float | None = None
    """The limit of the value."""
    unit: str = ""
    """Unit of value and limit; '1' for a number without unit."""
    decisive: bool = False
    """Whether its effect cannot be estimated, so that no decision is possible if it fails."""
    biases: tuple[Bias, ...] = ()
    """Of each point, in the order of the points; once it was judged, that of the mean first."""
    common: bool = True
    """Whether the biases are of one error, the same in all points: those do not average out."""
    covered_by: tuple[str, ...] = ()
    """Lines of the budget that already include part of the effect."""
    consequence: Consequence = Consequence.NOTHING
    of: tuple[tuple[str, Mapping[str, CoordinateValue]], ...] = ()
    """The results without a decision if it fails, each by name and coordinates; empty: all of the
    run."""
