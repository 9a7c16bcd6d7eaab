"""How the panels of a picture are painted: series, marks, limits, axes and the legend."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from io import BytesIO
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import style
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import FuncFormatter

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

    from rigrunner.api.data import Array
    from rigrunner.api.figures import Figure, Mark, Picture, Point, Series

INK, GREY = "#1f2933", "#5F6B7A"
STYLE: dict[str, Any] = {
    "svg.fonttype": "path",
    "svg.hashsalt": "rigrunner",
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titley": 1.0,  # or else it is looked for, in a sixth of the time of a drawing
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,  # a reader does not add 2.961e2 to each tick
    "axes.unicode_minus": True,
    "grid.color": "#E1E6EB",
    "grid.linewidth": 0.7,
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.5,
    "lines.markersize": 4.5,
    "errorbar.capsize": 2.5,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
}
WIDTH_IN = 8.4
MOST_SERIES = 12
"""The most that one panel shows."""
FEW = 2
"""So many panels above each other are high; of more each is lower."""
SHORT = 0.02
"""Of a limit at one point: its length to either side, as a share of the axis."""
CROWDED = 60
"""Of more points than this the marks are small."""
LETTERS, GAP = 112, 2
"""The space for names under a picture, and between two of them."""
COLUMNS, HANDLE = 4, 7
"""The most columns of a legend, and the space of the line before a name, in letters."""


@dataclass(frozen=True)
class Line:
    """What distinguishes a series: colour, dashes and marker together."""

    color: str
    dashes: str
    marker: str


BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, OCHRE = "#A04A84", "#8A6100"
"""Of the palette of Okabe and Ito (2008), distinguishable by most colour-blind readers.

The last ones are darkened until they keep a contrast of 3 to 1 on white.
"""
LINES = (
    Line(BLUE, "-", "o"),
    Line(VERMILION, "--", "D"),
    Line(GREEN, ":", "v"),
    Line(PURPLE, "-.", "s"),
    Line(OCHRE, ":", "^"),
    Line(GREY, "--", "P"),
)
_APART: dict[str, dict[str, Any]] = {
    "excluded": {"marker": "x", "color": VERMILION, "markersize": 6},
    "marked": {"marker": "s", "color": INK, "markersize": 8, "markerfacecolor": "none"},
}
"""Kinds that have a look of their own."""
_LIMIT: dict[str, Any] = {"color": INK, "linestyle": (0, (5, 3)), "linewidth": 1.3}


def painted(picture: Picture, *, titled: bool) -> Canvas:
    """Return a canvas with all panels of a picture, in our style."""
    with style.context(["default", STYLE]):
        canvas = Canvas(figsize=(WIDTH_IN, height_in(picture)), layout="constrained")
        paint(canvas, picture, titled=titled)
    return canvas


def as_svg(canvas: Canvas) -> bytes:
    """Return the canvas as SVG without a date.

    The bytes are those of Figure.savefig, which would draw everything again to find the layout.
    """
    buffer = BytesIO()
    with style.context(["default", STYLE]):
        FigureCanvasSVG(canvas).print_svg(buffer, metadata={"Date": None})  # type: ignore[no-untyped-call]  # matplotlib's
    return buffer.getvalue()


def height_in(picture: Picture) -> float:
    """Return how high a picture is drawn, in inches."""
    if picture.in_a_row or len(picture.panels) == 1:
        return 3.1
    return 0.8 + len(picture.panels) * (1.9 if len(picture.panels) <= FEW else 1.3)


def paint(canvas: Canvas, picture: Picture, *, titled: bool = False) -> None:
    """Paint all panels, and one legend of the named series above them."""
    panels = picture.panels
    grid = (1, len(panels)) if picture.in_a_row else (len(panels), 1)
    all_axes = canvas.subplots(*grid, sharex=not picture.in_a_row, squeeze=False).ravel()
    names = dict.fromkeys(
        series.name
        for panel in panels
        for series in panel.series
        if series.name and series.kind not in _APART
    )
    # A series is drawn alike in all panels, by its name.
    lines = {name: LINES[place % len(LINES)] for place, name in enumerate(names)}

    def date(seconds: float, _: object) -> str:
        return f"{datetime.fromtimestamp(seconds, UTC):%Y-%m-%d}"

    def number(value: float, _: object) -> str:
        return f"{value:.6g}".replace("-", "\N{MINUS SIGN}").replace(".", picture.decimal)

    for axes, figure in zip(all_axes, panels, strict=True):
        _panel(axes, figure, lines, picture.limit)
        if (titled or len(panels) > 1) and figure.title:
            axes.set_title(figure.title)
        if ticks := figure.x.ticks:
            # An axis of names shows as many, evenly spaced, as do not overlap.
            room = max(1, LETTERS // grid[1] // (GAP + max(len(name) for _, name in ticks)))
            shown = ticks[:: -(-len(ticks) // room)]
            axes.set_xticks([place for place, _ in shown], [name for _, name in shown])
            axes.grid(visible=False, axis="x")
        if figure.x.is_time:
            axes.xaxis.set_major_formatter(FuncFormatter(date))
        if picture.decimal != ".":
            axes.xaxis.set_major_formatter(FuncFormatter(number))
            axes.yaxis.set_major_formatter(FuncFormatter(number))
        if not picture.in_a_row and axes is not all_axes[-1]:
            axes.set_xlabel("")
    _legend(canvas, all_axes)


def limit_lines(points: Iterable[Point]) -> Iterator[tuple[list[float], list[float]]]:
    """Yield the lines of points' limits: over x where they follow it, or one value without x.

    A limit that some points alone have is a short line at each: nothing holds between them.
    """
    points = list(points)
    places = {point.x for point in points}
    half = SHORT * (max(places) - min(places)) if len(places) > 1 else 0.5
    for bounds in ([(p.x, p.lower) for p in points], [(p.x, p.upper) for p in points]):
        finite = sorted({(x, end) for x, end in bounds if end is not None and isfinite(end)})
        values = sorted({limit for _, limit in finite})
        if {x for x, _ in finite} != places:
            yield from (([x - half, x + half], [limit, limit]) for x, limit in finite)
        elif len(values) > 1:
            yield [x for x, _ in finite], [limit for _, limit in finite]
        else:
            yield from (([], [value]) for value in values)


def _panel(axes: Axes, figure: Figure, lines: Mapping[str, Line], limit: str) -> None:
    for mark in figure.marks:
        _mark(axes, mark)
    for series in figure.series[:MOST_SERIES]:
        _PAINTERS[series.kind](axes, series, lines.get(series.name, LINES[0]))
    points = [point for series in figure.series for point in series.points]
    label = limit
    limited = [
        series.points
        for series in figure.series
        if any(point.lower is not None or point.upper is not None for point in series.points)
    ]
    for xs, ys in limit_lines(point for points in limited for point in points):
        if xs:
            axes.plot(xs, ys, label=label, **_LIMIT)
        else:
            axes.axhline(ys[0], label=label, **_LIMIT)
        label = ""
    missed = [point for point in points if point.missed]
    if missed:
        x, y = _column(missed, "x"), _column(missed, "y")
        look: dict[str, Any] = {"marker": "X", "color": VERMILION, "markersize": 8, "zorder": 4}
        axes.plot(x, y, linestyle="", label="not passed", **look)
    axes.set(xlabel=str(figure.x), ylabel=str(figure.y))
    axes.margins(x=0.03, y=0.1)
    axes.set_xlim(figure.x.low, figure.x.high)
    axes.set_ylim(figure.y.low, figure.y.high)


def _mark(axes: Axes, mark: Mark) -> None:
    along = axes.axhline if mark.axis == "y" else axes.axvline
    if mark.end is not None:
        span = axes.axhspan if mark.axis == "y" else axes.axvspan
        span(mark.at, mark.end, color=BLUE, alpha=0.09, linewidth=0, zorder=0, label=mark.name)
    elif mark.is_limit:
        along(mark.at, label=mark.name, **_LIMIT)
    else:
        dashes = "-" if mark.axis == "y" else (0, (1, 2))
        along(mark.at, label=mark.name, color=INK, linewidth=0.7, linestyle=dashes, zorder=1)


def _points(axes: Axes, series: Series, line: Line) -> None:
    is_crowded = len(series.points) > CROWDED
    axes.errorbar(
        _column(series.points, "x"),
        _column(series.points, "y"),
        yerr=_half_widths(series.points),
        label=series.name,
        color=line.color,
        marker=line.marker,
        markersize=2.6 if is_crowded else None,
        linestyle=line.dashes if series.kind == "joined" else "none",
        linewidth=1.0,
        elinewidth=1.0,
    )


def _line(axes: Axes, series: Series, line: Line) -> None:
    x, y = _column(series.points, "x"), _column(series.points, "y")
    axes.plot(x, y, label=series.name, color=line.color, linestyle=line.dashes)
    half = _half_widths(series.points)
    if half is not None:
        axes.fill_between(x, y - half, y + half, color=line.color, alpha=0.15, linewidth=0)


def _bars(axes: Axes, series: Series, line: Line) -> None:
    x = _column(series.points, "x")
    width = float(np.diff(x).min()) if len(x) > 1 else 1.0
    look: dict[str, Any] = {"color": line.color, "alpha": 0.35, "linewidth": 0}
    axes.bar(x, _column(series.points, "y"), width, label=series.name, **look)


def _apart(axes: Axes, series: Series, _: Line) -> None:
    x, y = _column(series.points, "x"), _column(series.points, "y")
    axes.plot(x, y, label=series.name, linestyle="", zorder=3, **_APART[series.kind])


_PAINTERS = {
    "points": _points,
    "joined": _points,
    "line": _line,
    "bars": _bars,
    **dict.fromkeys(_APART, _apart),
}


def _legend(canvas: Canvas, all_axes: Iterable[Axes]) -> None:
    handles: dict[str, Artist] = {}
    for axes in all_axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    if handles:
        longest = sorted((len(label) + HANDLE for label in handles), reverse=True)[:COLUMNS]
        columns = max(n for n in range(1, len(longest) + 1) if n == 1 or sum(longest[:n]) < LETTERS)
        canvas.legend(handles.values(), handles, loc="outside upper center", ncols=columns)


def _half_widths(points: Sequence[Point]) -> Array | None:
    """Return U of each point, 0 where it is not known; None where none is."""
    half = _column(points, "U")
    return np.nan_to_num(half) if np.isfinite(half).any() else None


def _column(points: Sequence[Point], name: str) -> Array:
    return np.array([getattr(point, name) for point in points], dtype=float)
