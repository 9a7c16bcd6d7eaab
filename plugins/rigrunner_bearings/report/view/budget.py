"""The uncertainty budget of the primary method: at some frequencies, and of the mean."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, isnan
from typing import TYPE_CHECKING

from rigrunner.signal.coverage import expanded, factor
from rigrunner.signal.uncertainty import share_percent
from rigrunner_bearings.report.view.points import low_middle_high
from rigrunner_reports.numbers import MANY_DOF, UNKNOWN, fixed, plain, significant, to_place_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Component, Estimate
    from rigrunner_bearings.api.torque import TorqueDetails
    from rigrunner_bearings.report.view.points import SetPoint

MILLI = 1e3
MISSING = "\N{EM DASH}"
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
class Line:
    """One input at one frequency, as a budget table of the GUM has it."""

    name: str
    estimate: str
    distribution: str
    u: str
    unit: str
    sensitivity: str
    contribution: str
    dof: str
    share: str


@dataclass(frozen=True)
class Budget:
    """The budget of a method: `columns` are some frequencies, and the mean over all.

    `lines` is the whole of it at one of them, `at`.
    """

    method: str
    columns: tuple[str, ...]
    rows: tuple[BudgetRow, ...]
    totals: tuple[Total, ...]
    at: str
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class _Column:
    name: str
    components: tuple[Component, ...]
    estimate: Estimate


def budget(torque: TorqueDetails, points: Sequence[SetPoint]) -> Budget | None:
    """Return the primary method's budget, or None where it gave no points."""
    compensated = [point for point in points if torque.primary in point.by_method]
    if not compensated:
        return None
    columns = []
    for set_point in low_middle_high(compensated):
        point = set_point.by_method[torque.primary]
        name = f"{plain(point.set_frequency_hz)} Hz"
        columns.append(_Column(name, point.components, point.torque))
    detailed = columns[-1]
    shares = share_percent(detailed.components)
    if torque.headline is not None and torque.headline_components:
        columns.append(_Column("Mean", torque.headline_components, torque.headline))
    names = dict.fromkeys(part.name for column in columns for part in column.components)
    return Budget(
        method=torque.primary,
        columns=tuple(column.name for column in columns),
        rows=tuple(_row(name, columns) for name in names),
        totals=tuple(
            Total(
                u=significant(MILLI * column.estimate.u, 2),
                dof=degrees_of_freedom(column.estimate.dof),
                factor=fixed(factor(column.estimate), 2),
                expanded=significant(MILLI * expanded(column.estimate), 2),
            )
            for column in columns
        ),
        at=detailed.name,
        lines=tuple(
            Line(
                name=part.name,
                estimate=_estimate(part),
                distribution=part.distribution,
                u=significant(part.input_u, 2) if isfinite(part.input_u) else UNKNOWN,
                unit=part.unit,
                sensitivity=significant(part.sensitivity, 3)
                if isfinite(part.sensitivity)
                else MISSING,
                contribution=_milli(part.u),
                dof=degrees_of_freedom(part.dof),
                share=_share(share),
            )
            for part, share in zip(detailed.components, shares, strict=True)
        ),
    )


def _estimate(part: Component) -> str:
    """Return the estimate to the place of its uncertainty's second digit."""
    if not isfinite(part.value):
        return MISSING
    if part.value == 0:
        return "0"
    if not (isfinite(part.input_u) and part.input_u > 0):
        return plain(part.value)
    return to_place_of(part.value, part.input_u)


def _row(name: str, columns: Sequence[_Column]) -> BudgetRow:
    same = [
        next((part for part in column.components if part.name == name), None) for column in columns
    ]
    present = [part for part in same if part is not None]
    dofs = [part.dof for part in present]
    low_dof, high_dof = (degrees_of_freedom(dof) for dof in (min(dofs), max(dofs)))
    return BudgetRow(
        name=name,
        distribution=present[0].distribution,
        dof=low_dof if low_dof == high_dof else f"{low_dof} to {high_dof}",
        common="all points" if present[0].common else "each point",
        parts=tuple(
            _part(part, column.components) for part, column in zip(same, columns, strict=True)
        ),
    )


def _part(component: Component | None, components: Sequence[Component]) -> Part:
    if component is None:
        return Part(MISSING, MISSING, 0.0)
    share = share_percent(components)[components.index(component)]
    return Part(_milli(component.u), _share(share), round(share, 1) if isfinite(share) else 0.0)


def _share(percent: float) -> str:
    if not isfinite(percent):
        return MISSING
    return "< 1 %" if 0 < percent < LEAST_SHARE else f"{percent:.0f} %"


def _milli(u_nm: float) -> str:
    """Return a torque in mN·m with two significant digits, or that there is next to nothing."""
    if not isfinite(u_nm):
        return UNKNOWN
    if u_nm == 0:
        return "0"
    return f"< {LEAST_MILLI}" if MILLI * u_nm < LEAST_MILLI else significant(MILLI * u_nm, 2)


def degrees_of_freedom(dof: float) -> str:
    """Return degrees of freedom as a whole number, as GUM G.4.1 rounds them: downwards."""
    if isnan(dof):
        return UNKNOWN
    return f"{int(dof)}" if dof < MANY_DOF else "∞"
