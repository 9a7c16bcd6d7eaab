"""A section of the report, as a record: what it shows, and where it stands.

Another package brings sections by an entry point of the group `rigrunner_reports.sections`, which
names its `Sections`. A section that is text, figures and tables alone needs none of this: an
analysis gives it as data (`Findings.sections`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from rigrunner.api import PluginError

if TYPE_CHECKING:
    from collections.abc import Callable
    from importlib.metadata import EntryPoint

    from rigrunner.api import ReportInput

GROUP = "rigrunner_reports.sections"
TILES, BELOW = "tiles", "below"
"""Inside the section of the result: beside the tile of the limit, and below the tiles."""


@dataclass(frozen=True)
class Section:
    """A section; its template is given what `view` returned as `view`, and the page as `page`.

    Those of `rigrunner_reports` itself are the `SECTIONS` of the modules of its package `view`.
    """

    name: str
    """Of its template `templates/NAME.html.j2`, and its anchor in the page."""
    title: str
    """In the contents."""
    place: int
    """Sections stand in this order, from 0, the result, to 120, what made the report. In the tiles
    the limit stands at 50."""
    view: Callable[[ReportInput, Any], object]
    """Returns what the section shows, of the report's input and the page of its package; nothing
    leaves it out."""
    unbroken: bool = False
    """Whether each number keeps its unit beside it on one line."""
    anchor: str = ""
    """In the page, where it is not the name."""
    inside: str = ""
    """Where it stands inside the section of the result, `TILES` or `BELOW`; '' of its own."""
    package: str = ""
    """The package with its template; '' of `rigrunner_reports` itself."""

    @property
    def template(self) -> str:
        """The template by its name for the loader."""
        return "/".join(filter(None, (self.package, f"{self.name}.html.j2")))


@dataclass(frozen=True)
class Headline:
    """The large number: value and interval, or words where there is none."""

    label: str
    symbol: str
    value: str
    interval: str
    unit: str
    detail: str
    problem: str = ""


@dataclass(frozen=True)
class Sections:
    """What a package brings to the report."""

    page: Callable[[ReportInput], Any]
    """Returns what its sections take what they show from; None: it brings nothing to this one."""
    sections: tuple[Section, ...]
    headline: Callable[[ReportInput, Any], Headline | None]
    """Returns the large number of the report; None leaves it to others."""


@cache
def brought() -> tuple[Sections, ...]:
    """Return what installed packages bring, in the order of their names; raise PluginError."""
    return tuple(map(_loaded, sorted(entry_points(group=GROUP), key=lambda each: each.name)))


def _loaded(entry: EntryPoint) -> Sections:
    try:
        found = entry.load()
    except Exception as error:
        raise PluginError(
            f"the report sections of '{entry.name}' cannot be loaded: {error}"
        ) from error
    if not isinstance(found, Sections):
        raise PluginError(f"{entry.value} ({entry.name}): got {found!r}, expected Sections")
    return found
