"""Lines of the budgets of a curve's points: what several points have in common.

A line that is common to all points, such as the gain of one meter or a constant of an equation,
moves them together. A line that may be another one at each point counts with its greatest possible
effect. Lines of one point alone (type A) only weight the points: the scatter about the curve shows
them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot, inf, isfinite, isnan, nan
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Array, Component


@dataclass(eq=False)
class SharedLine:
    """A budget line that several points have, and what its standard uncertainty changes there."""

    line: Component
    """As it stands in a point's budget; `input_u` is nan if it is not the same in all."""
    by: Array
    """The change of y and of each x in SI, shape (1 + k, n)."""

    @property
    def name(self) -> str:
        """Its name."""
        return self.line.name

    @property
    def is_one_error(self) -> bool:
        """Whether it is the same error at all points."""
        return self.line.shared

    def of_result(self, name: str, effect: float) -> Component:
        """Return a line of a result's budget from what one standard uncertainty changes it by."""
        line = self.line
        if isnan(line.input_u):  # it differs from point to point: the input is one of it at each
            line = replace(line, value=nan, unit="1", input_u=1.0)
        # What was one error at a place is a sum of those of all points.
        return replace(
            line, name=name, u=abs(effect), sensitivity=effect / line.input_u, at_place=False
        )


def shared_lines(
    points: Sequence[Sequence[Sequence[Component]]],
) -> tuple[tuple[SharedLine, ...], Array, Array, Array]:
    """Return the lines that points may share, u of each y's own scatter, its dof, and u of x, (n,).

    `points` has for each point the budget of y and of each x; u of each line is in SI.
    """
    lines: dict[tuple[str, str, str, float | None], SharedLine] = {}
    u_y, welch_sum, u_x = np.zeros((3, len(points)))
    for i, point in enumerate(points):
        for row, budget in enumerate(point):
            for line in budget:
                if line.u == 0:
                    continue
                if line.common:
                    value = line.value if isfinite(line.value) else None
                    shared = lines.setdefault(
                        (line.name, line.unit, line.distribution, value),
                        SharedLine(_as_shared(line), np.zeros((len(point), len(points)))),
                    )
                    shared.by[row, i] += -line.u if line.sensitivity < 0 else line.u
                    # Its size may be that at one reading: a share of it, a row of a certificate.
                    is_same_size = shared.line.input_u == line.input_u
                    shared.line = replace(
                        shared.line,
                        input_u=line.input_u if is_same_size else nan,
                        dof=min(shared.line.dof, line.dof),
                    )
                elif row:  # it takes the point off the curve, as residuals show
                    u_x[i] = hypot(u_x[i], line.u)
                else:
                    u_y[i] = hypot(u_y[i], line.u)
                    welch_sum[i] += line.u**4 / line.dof  # Welch and Satterthwaite (GUM G.4.1)
    dof = np.full(len(points), inf)
    np.divide(u_y**4, welch_sum, out=dof, where=welch_sum > 0)
    return tuple(lines.values()), u_y, dof, u_x


def _as_shared(line: Component) -> Component:
    """Return a line as points share it; one without a sign may be another error at each point."""
    if isfinite(line.sensitivity) and not (isnan(line.value) and line.sensitivity == 1):
        return line
    return replace(line, shared=False, input_u=nan)
