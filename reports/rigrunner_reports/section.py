"""A section of the report, as a record: its content and its place.

Another package adds sections by an entry point of the group `rigrunner_reports.sections`, which
names its `Sections`. A section of text, figures and tables alone needs none of this: an analysis
gives it as data (`Findings.sections`).
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
    """A section; its template gets the value of `view` as `view`, and the page as `page`.

    Those of `rigrunner_reports` itself are the `SECTIONS` of the modules of its package `view`.
    """

    name: str
    """The name of its template `templates/NAME.html.j2`, and its anchor in the page."""
    title: str
    """The title in the contents."""
    place: int
    """Sections are in this order, from 0, the result, to 120, software and versions. Among the
    tiles the limit is at 50."""
    view: Callable[[ReportInput, Any], object]
    """Returns the content, from the report's input and the page of its package; with nothing, the
    section is left out."""
    unbroken: bool = False
    """Whether each number keeps its unit on the same line."""
    anchor: str = ""
    """The anchor in the page, if it is not the name."""
    inside: str = ""
    """Its place inside the section of the result, `TILES` or `BELOW`; '' for a section of its own.
    """
    package: str = ""
    """The package with its template; '' for `rigrunner_reports` itself."""

    @property
    def template(self) -> str:
        """The name of the template for the loader."""
        return "/".join(filter(None, (self.package, f"{self.name}.html.j2")))


@dataclass(frozen=True)
class Headline:
    """The large number: value and interval, or a text if there is none."""

    label: str
    symbol: str
    value: str
    interval: str
    unit: str
    detail: str
    problem: str = ""


@dataclass(frozen=True)
class Sections:
    """The sections of a package."""

    page: Callable[[ReportInput], Any]
    """Returns the page for its sections; None: it adds nothing to this report."""
    sections: tuple[Section, ...]
    headline: Callable[[ReportInput, Any], Headline | None]
    """Returns the large number of the report; None leaves it to others."""


@cache
def installed_sections() -> tuple[Sections, ...]:
    """Return the sections of installed packages, in the order of their names; raise PluginError."""
    return tuple(map(_load, sorted(entry_points(group=GROUP), key=lambda entry: entry.name)))


def _load(entry: EntryPoint) -> Sections:
    try:
        sections = entry.load()
    except Exception as error:
        raise PluginError(
            f"the report sections of '{entry.name}' cannot be loaded: {error}"
        ) from error
    if not isinstance(sections, Sections):
        raise PluginError(f"{entry.value} ({entry.name}): got {sections!r}, expected Sections")
    return sections
