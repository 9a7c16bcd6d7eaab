"""What follows from a check: a line of the budget, no verdict, or a note.

A failed check states by how much it moves each point. If that matters, it enters the budget as a
line with the check's name: the result is not corrected, so the root mean square of what it may
be wrong by is a standard uncertainty (GUM F.2.4.5; as Nordtest TR 537 takes the bias of a method).
What is already in the budget is not counted twice. A bias that is too large for that, and a check
that cannot state its own, make the verdict inconclusive. Anything else is a note.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Effect, Input
from rigrunner.api.analysis import Bias, Consequence
from rigrunner.api.verdict import MEAN
from rigrunner_bearings.signal.mean_model import with_effects
from rigrunner_bearings.torque.headline import compensated_mean

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api import Check
    from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation

MATTERS = 1 / 3
"""Of the standard uncertainty of the mean: a smaller bias increases it by less than 6 %."""

MATTERS_AT_A_POINT = 1.0
"""Of that of a set-point, of which a run has many: a smaller bias increases it by up to 41 %."""

TRUSTED = 0.05
"""Of the torque: a greater bias is a fault of the run, and no estimate of it is good enough."""


def bind(
    compensation: Compensation, checks: Iterable[Check]
) -> tuple[Compensation, tuple[Check, ...]]:
    """Return the compensation with what the checks found in its budget, and the checks as judged.

    The checks are taken in their order: a later one sees what an earlier one put into the budget.
    """
    judged_checks = []
    for check in checks:
        judged = _judged(check, compensation.points)
        if judged.consequence is Consequence.BUDGET:
            cause = Input(judged.name, 0.0, 1.0, unit="1", common=judged.common)
            compensation = replace(
                compensation,
                points=tuple(
                    with_effects(point, [Effect(cause, _missing_from_budget(point, bias, judged))])
                    for point, bias in zip(compensation.points, judged.biases[1:], strict=True)
                ),
            )
        judged_checks.append(judged)
    return compensation, tuple(judged_checks)


def _judged(check: Check, points: Sequence[CompensatedPoint]) -> Check:
    judged = replace(check, biases=_with_mean(check)) if check.biases else check
    if check.ok:
        return judged
    consequence = _consequence(judged, points)
    fails = consequence is not Consequence.NOTE
    return replace(judged, ok=not fails, consequence=consequence)


def _with_mean(check: Check) -> tuple[Bias, ...]:
    count = len(check.biases)
    u = [bias.u for bias in check.biases]
    u_mean = sum(u) / count if check.common else sqrt(sum(u_point**2 for u_point in u)) / count
    mean = sum(bias.value for bias in check.biases) / count
    return (Bias(MEAN, mean, u_mean, check.biases[0].unit), *check.biases)


def _consequence(check: Check, points: Sequence[CompensatedPoint]) -> Consequence:
    if check.decisive:
        return Consequence.INCONCLUSIVE
    if not check.biases or not points:
        return Consequence.NOTE
    mean, *biases = check.biases
    level = float(np.mean([abs(point.torque.value) for point in points]))
    apart = 0.0
    if not check.common:
        apart = sqrt(sum(bias.contribution**2 for bias in biases) / len(biases))
    if max(mean.contribution, apart) > TRUSTED * level:
        return Consequence.INCONCLUSIVE
    lacking = [_missing_from_budget(*pair, check) for pair in zip(points, biases, strict=True)]
    of_mean = sum(lacking) / len(lacking)
    if not check.common:
        of_mean = sqrt(sum(part**2 for part in lacking)) / len(lacking)
    matters = abs(of_mean) > MATTERS * compensated_mean(points).u or any(
        abs(part) > MATTERS_AT_A_POINT * point.torque.u
        for part, point in zip(lacking, points, strict=True)
    )
    return Consequence.BUDGET if matters else Consequence.NOTE


def _missing_from_budget(point: CompensatedPoint, bias: Bias, check: Check) -> float:
    """Return what the budget of a point lacks of a bias in N·m, with the sign of the bias."""
    has = hypot(*(part.u for part in point.components if part.name in check.covered_by))
    lacking = sqrt(max(bias.contribution**2 - has**2, 0.0))
    return lacking if bias.value >= 0 else -lacking
