"""From a picture as data to a drawing: one style, no global state left behind, no date."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure as Canvas

    from rigrunner.api.figures import Picture

WIDTH_IN = 8.4


@dataclass(frozen=True, eq=False)
class Plot:
    """A picture that was drawn: a notebook shows it, a page embeds it, and it can be saved."""

    picture: Picture
    figure: Canvas
    """Of matplotlib, to change or add to."""

    @property
    def caption(self) -> str:
        """What it shows, in a sentence."""
        return self.picture.caption

    @property
    def alt(self) -> str:
        """The same in numbers, for those who do not see it."""
        return self.picture.alt

    @cached_property
    def svg(self) -> bytes:
        """The drawing; the same picture gives the same bytes.

        They are those of Figure.savefig, which would draw everything once more to find the layout.
        """
        from matplotlib import style  # noqa: PLC0415  (half a second, for those who plot)
        from matplotlib.backends.backend_svg import FigureCanvasSVG  # noqa: PLC0415  (the same)

        from rigrunner.plots.panels import STYLE  # noqa: PLC0415  (the same)

        buffer = BytesIO()
        with style.context(["default", STYLE]):
            canvas = FigureCanvasSVG(self.figure)
            canvas.print_svg(buffer, metadata={"Date": None})  # type: ignore[no-untyped-call]  # matplotlib's
        return buffer.getvalue()

    @property
    def uri(self) -> str:
        """The drawing as the source of an <img>, so that its names stay its own."""
        return f"data:image/svg+xml;base64,{b64encode(self.svg).decode('ascii')}"

    def save(self, path: Path | str) -> None:
        """Write it to a file: .svg, .pdf, .png; raise UsageError where that cannot be done."""
        try:
            self.figure.savefig(path, bbox_inches="tight", dpi=150)
        except (OSError, ValueError) as error:
            raise UsageError(f"{path} cannot be written: {error}") from error

    def _repr_svg_(self) -> str:
        """Return what a notebook shows."""
        return self.svg.decode()


def draw(picture: Picture, *, titled: bool = False) -> Plot:
    """Return the drawing of a picture; the user's own settings of matplotlib change nothing.

    A panel alone has its title where no caption stands below the drawing: `titled`.
    """
    from matplotlib import style  # noqa: PLC0415  (half a second, for those who plot)
    from matplotlib.figure import Figure as Canvas  # noqa: PLC0415  (the same)

    from rigrunner.plots.panels import STYLE, height_in, paint  # noqa: PLC0415  (the same)

    with style.context(["default", STYLE]):
        canvas = Canvas(figsize=(WIDTH_IN, height_in(picture)), layout="constrained")
        paint(canvas, picture, titled=titled)
    return Plot(picture, canvas)
