"""Figures as data, which report, certificate, panel and notebook draw."""

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

points: measured values, with U as bars; joined: these, with a thin line between them; line: a
curve, with U as a band; bars: a histogram, with x in the middle of each class; excluded: crosses,
of values that do not take part; marked: open squares around points of another series.
"""


@dataclass(frozen=True)
class Axis:
    """What is along an axis."""

    name: str
    unit: str = ""
    low: float | None = None
    """Where the axis begins and ends; None: where the values do."""
    high: float | None = None
    ticks: tuple[tuple[float, str], ...] = ()
    """Places with their names, of an axis that has no scale of numbers."""
    is_time: bool = False
    """Whether its values are seconds since 1970 (UTC), shown as dates."""

    def __str__(self) -> str:
        """Return it as it stands at the axis: 'R / Ω'."""
        if self.unit in {"", "1"}:
            return self.name
        compound = "/" in self.unit and len(self.unit) > len("1/")
        return f"{self.name} / ({self.unit})" if compound else f"{self.name} / {self.unit}"


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
    """'' for the only one; series of one name are drawn alike in all panels of a picture."""
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
        """Return the series of columns of one length; a U that is not finite is not known."""
        half = repeat(None) if U is None else (each if isfinite(each) else None for each in U)
        columns = map(float, x), map(float, y), half
        return cls(name, tuple(starmap(Point, zip(*columns, strict=U is not None))), kind)


@dataclass(frozen=True)
class Mark:
    """A value that is marked across a figure: a line, or the area up to another value."""

    axis: Literal["x", "y"]
    at: float
    end: float | None = None
    """The other end of an area; None of a line."""
    name: str = ""
    is_limit: bool = False


@dataclass(frozen=True)
class Figure:
    """Series over one coordinate, drawn alike by report, panel and notebook."""

    title: str
    x: Axis
    y: Axis
    series: tuple[Series, ...]
    marks: tuple[Mark, ...] = ()
    of: str = ""
    """The name of the result with which an analysis gives it."""
    caption: str = ""
    """What it shows, in a sentence; '' where its title says it."""

    @property
    def has_limits(self) -> bool:
        """Whether any point has a limit, or all have."""
        return any(mark.is_limit for mark in self.marks) or any(
            end is not None
            for series in self.series
            for point in series.points
            for end in (point.lower, point.upper)
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Curve:
    """A curve that a screen shows as soon as it is measured, such as one cycle over its phase."""

    title: str
    x: Axis
    y: Axis
    at: Array
    """The values of x, shape (n,)."""
    series: Mapping[str, Array]
    """The values of y by the name of the series, each of shape (n,); at most two."""
    end_s: float
    """When it was complete, in seconds of its recording."""
    frequency_hz: float | None = None
    """Of the cycle that it shows; None where it shows none."""


@dataclass(frozen=True)
class Picture:
    """Figures that a document shows together, with one caption."""

    caption: str
    alt: str
    """What it shows in words and numbers, for those who do not see it."""
    panels: tuple[Figure, ...]
    in_a_row: bool = False
    """Whether the panels stand side by side; else above each other, on one x axis."""
    limit: str = "limit"
    """What limits of points are called, in the language of the document."""
    decimal: str = "."
    """The decimal sign of that language."""
