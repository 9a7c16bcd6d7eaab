"""From a picture as data to a drawing: one style, no global state left behind, no date."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure as Canvas

    from rigrunner.api.figures import Picture


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
        """The drawing; the same picture gives the same bytes."""
        from rigrunner.plots.panels import as_svg  # noqa: PLC0415  (matplotlib: half a second)

        return as_svg(self.figure)

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
        """Return the SVG for a notebook."""
        return self.svg.decode()


def draw(picture: Picture, *, titled: bool = False) -> Plot:
    """Return the drawing of a picture; the user's own settings of matplotlib change nothing.

    `titled`: a single panel has its title too, where no caption is below the drawing.
    """
    from rigrunner.plots.panels import painted  # noqa: PLC0415  (matplotlib: half a second)

    return Plot(picture, painted(picture, titled=titled))
