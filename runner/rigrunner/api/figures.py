"""Figures as data, drawn by report, certificate, panel and notebook."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import repeat, starmap
from math import isfinite
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.data import Array

SeriesKind = Literal["points", "joined", "line", "bars", "excluded", "marked"]
"""How a series is drawn.

points: measured values, with U as bars; joined: the same with a thin line; line: a curve, with U as
a band; bars: a histogram, with x at the middle of each class; excluded: crosses for excluded
values; marked: open squares around points of another series.
"""


@dataclass(frozen=True)
class Axis:
    """An axis of a figure."""

    name: str
    unit: str = ""
    low: float | None = None
    """Start and end of the axis; None: from the values."""
    high: float | None = None
    ticks: tuple[tuple[float, str], ...] = ()
    """Positions with labels, for an axis without a numerical scale."""
    is_time: bool = False
    """Whether values are seconds since 1970 (UTC), shown as dates."""

    def __str__(self) -> str:
        """Return the label of the axis: 'R / Ω'."""
        if self.unit in {"", "1"}:
            return self.name
        return f"{self.name} / ({self.unit})" if "/" in self.unit else f"{self.name} / {self.unit}"


@dataclass(frozen=True)
class Point:
    """A value of a series, in the units of the axes."""

    x: float
    y: float
    U: float | None = None
    """Expanded uncertainty of y (95 %), if known."""
    lower: float | None = None
    """Limits of y at this point; None for none."""
    upper: float | None = None
    missed: bool = False
    """Whether it misses its limits by the decision rule, if there is one."""


@dataclass(frozen=True)
class Series:
    """Points in one style."""

    name: str
    """'' for the only one; series of one name have the same style in all panels of a picture."""
    points: tuple[Point, ...]
    kind: SeriesKind = "points"

    @classmethod
    def over(
        cls,
        x: Iterable[float],
        y: Iterable[float],
        name: str = "",
        kind: SeriesKind = "points",
        U: Iterable[float] | None = None,  # noqa: N803  (the symbol of GUM)
    ) -> Series:
        """Return the series of columns of equal length; a U that is not finite is unknown."""
        half = repeat(None) if U is None else (u if isfinite(u) else None for u in U)
        columns = map(float, x), map(float, y), half
        # Without U the third column has no end, so equal lengths cannot be asked for.
        return cls(name, tuple(starmap(Point, zip(*columns, strict=U is not None))), kind)


@dataclass(frozen=True)
class Mark:
    """A marked value: a line across the figure, or the area up to another value."""

    axis: Literal["x", "y"]
    at: float
    end: float | None = None
    """Other end of an area; None for a line."""
    name: str = ""
    is_limit: bool = False


@dataclass(frozen=True)
class Figure:
    """Series over one coordinate."""

    title: str
    x: Axis
    y: Axis
    series: tuple[Series, ...]
    marks: tuple[Mark, ...] = ()
    of: str = ""
    """Name of the result that an analysis gives it for."""
    caption: str = ""
    """Description in one sentence; '' if the title is enough."""

    @property
    def has_limits(self) -> bool:
        """Whether any point, or all, have a limit."""
        return any(mark.is_limit for mark in self.marks) or any(
            end is not None
            for series in self.series
            for point in series.points
            for end in (point.lower, point.upper)
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Curve:
    """A curve for immediate display, such as one cycle over its phase."""

    title: str
    x: Axis
    y: Axis
    at: Array
    """Values of x, shape (n,)."""
    series: Mapping[str, Array]
    """Values of y by name of the series, each of shape (n,); at most two."""
    end_s: float
    """Time of its end, in seconds of its recording."""
    frequency_hz: float | None = None
    """Frequency of its cycle; None if it shows none."""


@dataclass(frozen=True)
class Picture:
    """Figures with one caption."""

    caption: str
    alt: str
    """Description in words and numbers, for people who cannot see it."""
    panels: tuple[Figure, ...]
    in_a_row: bool = False
    """Whether the panels are side by side; else above each other, on one x axis."""
    limit: str = "limit"
    """Label of limits of points, in the language of the document."""
    decimal: str = "."
    """Decimal sign of that language."""
