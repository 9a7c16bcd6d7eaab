"""Figures as data, which report, panel and notebook draw: points with uncertainty and limits."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Axis:
    """What is along an axis."""

    name: str
    unit: str = ""

    def __str__(self) -> str:
        """Return it as it stands at the axis: 'R / Ω'."""
        return self.name if self.unit in {"", "1"} else f"{self.name} / {self.unit}"


@dataclass(frozen=True)
class Point:
    """A value of a series, in the units of the axes."""

    x: float
    y: float
    U: float | None = None
    """The expanded uncertainty of y for 95 %, where it is known."""
    lower: float | None = None
    """What y may be there; None where there is no such limit."""
    upper: float | None = None
    missed: bool = False
    """Whether it is not within its limits by the rule that decides, so far as one does."""


@dataclass(frozen=True)
class Series:
    """Points that belong together, by x."""

    name: str
    """'' for the only one."""
    points: tuple[Point, ...]
    is_line: bool = False
    """Whether it is a curve, with U as a band; else its points are measured, with U as bars."""


@dataclass(frozen=True)
class Figure:
    """Series over one coordinate, drawn alike by report, panel and notebook."""

    title: str
    x: Axis
    y: Axis
    series: tuple[Series, ...]
    of: str = ""
    """The name of the result with which an analysis gives it."""
    caption: str = ""
    """What it shows, in a sentence; '' where its title says it."""

    @property
    def has_limits(self) -> bool:
        """Whether any point has a limit."""
        return any(
            end is not None
            for series in self.series
            for point in series.points
            for end in (point.lower, point.upper)
        )
