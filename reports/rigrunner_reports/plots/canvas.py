"""From a painting function to SVG bytes: one style, no global state left behind, no date."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

from matplotlib import style
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from collections.abc import Callable

INK = "#1f2933"
BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
"""Of the palette of Okabe and Ito (2008), told apart by most colour-blind readers."""
PURPLE, OCHRE, GREY = "#A04A84", "#8A6100", "#5F6B7A"
"""Darkened until they keep a contrast of 3 to 1 on white."""

WIDTH_IN = 8.4
STYLE = {
    "svg.fonttype": "path",
    "svg.hashsalt": "rigrunner",
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
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


@dataclass(frozen=True)
class Line:
    """How a series is told apart: colour, dashes and marker together."""

    color: str
    linestyle: str
    marker: str


RAW = Line(VERMILION, "--", "D")
NO_LOAD = Line(GREEN, ":", "v")
PRIMARY = Line(BLUE, "-", "o")
OTHERS = (Line(PURPLE, "-.", "s"), Line(OCHRE, (":"), "^"), Line(GREY, "--", "P"))
LOW_MIDDLE_HIGH = (Line(GREEN, ":", "v"), Line(PURPLE, "--", "s"), Line(BLUE, "-", "o"))


@dataclass(frozen=True)
class Plot:
    """A figure: the caption explains it, the alternative text says its numbers."""

    caption: str
    alt: str
    svg: bytes

    @property
    def uri(self) -> str:
        """The figure as the source of an <img>, so that its names stay its own."""
        return f"data:image/svg+xml;base64,{b64encode(self.svg).decode('ascii')}"


def draw(paint: Callable[[Figure], None], height_in: float) -> bytes:
    """Return what `paint` draws as SVG; the same input gives the same bytes.

    They are those of Figure.savefig, which would draw everything once more to find the layout.
    """
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
        canvas = FigureCanvasSVG(figure)
        paint(figure)
        buffer = BytesIO()
        canvas.print_svg(buffer, metadata={"Date": None})  # type: ignore[no-untyped-call]  # matplotlib's
    return buffer.getvalue()


def line_of(name: str, names: list[str], primary: str) -> Line:
    """Return how a method is drawn: the primary one always alike."""
    if name == primary:
        return PRIMARY
    others = [each for each in names if each != primary]
    return OTHERS[others.index(name) % len(OTHERS)]
