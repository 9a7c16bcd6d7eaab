"""One style for the plots of notebooks, without global state, so that none stays behind."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from matplotlib.figure import Figure

BLUE, VERMILION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, OCHRE, GREY = "#A04A84", "#8A6100", "#5F6B7A"
"""Of the palette of Okabe and Ito (2008), the last ones darkened for contrast on white."""
INK = "#1f2933"
SERIES = tuple(zip((BLUE, VERMILION, GREEN, PURPLE, OCHRE, GREY), "os^DvP", strict=True))
"""How series are told apart, not by colour alone; a seventh begins anew."""
_STYLE: dict[str, Any] = {
    "font.size": 9,
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,  # a reader does not add 2.961e2 to each tick
    "grid.color": "#E1E6EB",
    "text.color": INK,
    "text.parse_math": False,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    "legend.frameon": False,
    "errorbar.capsize": 2.5,
}
_INCHES = (7.5, 3.6)


@dataclass(frozen=True, eq=False)
class Plot:
    """A figure that a notebook shows, and that can be saved."""

    figure: Figure
    """Of matplotlib, to change or add to."""

    def save(self, path: Path | str) -> None:
        """Write it to a file: .svg, .pdf, .png; raise UsageError where that cannot be done."""
        try:
            self.figure.savefig(path, bbox_inches="tight", dpi=150)
        except (OSError, ValueError) as error:
            raise UsageError(f"{path} cannot be written: {error}") from error

    def _repr_svg_(self) -> str:
        """Return what a notebook shows."""
        text = BytesIO()
        self.figure.savefig(text, format="svg", bbox_inches="tight")
        return text.getvalue().decode()


def drawn(paint: Callable[[Figure], None], *, rows: int = 1) -> Plot:
    """Return the plot that a function paints on an empty figure, for so many rows of axes."""
    from matplotlib import style  # noqa: PLC0415  (half a second, for those who plot)
    from matplotlib.figure import Figure  # noqa: PLC0415  (the same)

    with style.context(["default", _STYLE]):
        figure = Figure(figsize=(_INCHES[0], _INCHES[1] * max(1.0, rows / 2)), layout="constrained")
        paint(figure)
    return Plot(figure)
