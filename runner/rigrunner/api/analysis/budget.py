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
    """One line of an uncertainty budget (GUM 8): an input, and what it contributes."""

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
    """The result's change over the input's; 1 for a line of several inputs."""
    shared: bool = True
    """Whether a line of this name in another result is the same error. False of an error that may
    be another one at each reading: nobody states what two results have of it in common."""


class Consequence(StrEnum):
    """What follows from a check."""

    NOTHING = ""
    NOTE = "note"
    """Something was found that moves no result by as much as matters."""
    BUDGET = "budget"
    """What was found has a line of its own in the uncertainty budget."""
    INCONCLUSIVE = "inconclusive"
    """Nothing can be decided on the result."""


@dataclass(frozen=True)
class Bias:
    """By how much what a check found moves a result that is not corrected for it (VIM 2.18)."""

    of: str
    """'mean', or the set-point: '35 Hz'."""
    value: float
    u: float
    unit: str = "N·m"

    @property
    def contribution(self) -> float:
        """The root mean square of what the result may be wrong by: a standard uncertainty."""
        return hypot(self.value, self.u)


@dataclass(frozen=True)
class Check:
    """A named check: its finding, its limit and its advice.

    A method says in `ok` whether it found anything, and in `biases` by how much that moves each of
    its points. What follows from it, the analysis decides; from then on `ok`
    is False only of a check that binds.
    """

    name: str
    ok: bool
    text: str
    advice: str = ""
    value: float | None = None
    """What was found, or the worst of it; None where it is not a number."""
    threshold: float | None = None
    """What it may be at most or at least."""
    unit: str = ""
    """Of both: '1' for a bare number."""
    decisive: bool = False
    """Whether its effect cannot be estimated, so that nothing can be decided where it failed."""
    biases: tuple[Bias, ...] = ()
    """Of each point, in the order of the points; once it was judged, that of the mean first."""
    common: bool = True
    """Whether the biases are of one error, the same in all points: those do not average out."""
    covered_by: tuple[str, ...] = ()
    """Lines of the budget that have a part of the effect already."""
    consequence: Consequence = Consequence.NOTHING
    of: tuple[tuple[str, Mapping[str, CoordinateValue]], ...] = ()
    """The results on which nothing can be decided if it failed, each by its name and coordinates;
    empty: all of the run."""
