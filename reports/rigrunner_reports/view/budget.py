"""The uncertainty budget of the primary method at a low, a middle and a high frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_reports.numbers import expanded, fixed, plain, significant
from rigrunner_reports.view.points import low_middle_high

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.analysis import CompensatedPoint, Component
    from rigrunner.api.results import Result
    from rigrunner_reports.view.points import SetPoint

MILLI = 1e3
MISSING = "\N{EM DASH}"
MANY_DOF = 1e4
LEAST_MILLI = 0.01
LEAST_SHARE = 0.5


@dataclass(frozen=True)
class Part:
    """One component at one frequency: u in mN·m and its share of the variance in per cent."""

    u: str
    share: str
    percent: float


@dataclass(frozen=True)
class BudgetRow:
    """One component over the shown frequencies."""

    name: str
    distribution: str
    dof: str
    common: str
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Total:
    """The combined result at one frequency, in mN·m."""

    u: str
    dof: str
    factor: str
    expanded: str


@dataclass(frozen=True)
class Budget:
    """The budget of a method; `frequencies` are the columns."""

    method: str
    frequencies: tuple[str, ...]
    rows: tuple[BudgetRow, ...]
    totals: tuple[Total, ...]


def budget(result: Result, points: Sequence[SetPoint]) -> Budget | None:
    """Return the primary method's budget, or None where it gave no points."""
    shown = low_middle_high([each for each in points if result.primary in each.by_method])
    if not shown:
        return None
    found = [each.by_method[result.primary] for each in shown]
    names = dict.fromkeys(part.name for point in found for part in point.components)
    rows = [(name, _row(name, found)) for name in names]
    return Budget(
        method=result.primary,
        frequencies=tuple(f"{plain(each.point.set_frequency_hz)} Hz" for each in shown),
        rows=tuple(row for _, row in rows),
        totals=tuple(_total(point) for point in found),
    )


def _row(name: str, points: Sequence[CompensatedPoint]) -> BudgetRow:
    same = [_component(name, point) for point in points]
    known = [part for part in same if part is not None]
    return BudgetRow(
        name=name,
        distribution=known[0].distribution,
        dof=_range([part.dof for part in known]),
        common="all points alike" if known[0].common else "each point",
        parts=tuple(_part(part, point) for part, point in zip(same, points, strict=True)),
    )


def _component(name: str, point: CompensatedPoint) -> Component | None:
    return next((part for part in point.components if part.name == name), None)


def _part(component: Component | None, point: CompensatedPoint) -> Part:
    if component is None:
        return Part(MISSING, MISSING, 0.0)
    total = sum(part.u**2 for part in point.components)
    share = 100 * component.u**2 / total if total > 0 else 0.0
    shown = "< 1 %" if 0 < share < LEAST_SHARE else f"{share:.0f} %"
    return Part(_milli(component.u), shown, round(share, 1))


def _milli(u_nm: float) -> str:
    """Return a torque in mN·m with two significant digits, or that there is next to nothing."""
    return f"< {LEAST_MILLI}" if MILLI * u_nm < LEAST_MILLI else significant(MILLI * u_nm, 2)


def _total(point: CompensatedPoint) -> Total:
    torque = point.torque
    return Total(
        u=significant(MILLI * torque.u, 2),
        dof=degrees_of_freedom(torque.dof),
        factor=fixed(coverage_factor(torque.dof), 2),
        expanded=significant(MILLI * expanded(torque), 2),
    )


def degrees_of_freedom(dof: float) -> str:
    """Return degrees of freedom as a whole number, as GUM G.4.1 rounds them: downwards."""
    return f"{int(dof)}" if dof < MANY_DOF else "∞"


def _range(dofs: Sequence[float]) -> str:
    low, high = (degrees_of_freedom(each) for each in (min(dofs), max(dofs)))
    return low if low == high else f"{low} to {high}"
