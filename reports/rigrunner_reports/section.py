"""A section of the report, as a record: what it shows, and where it stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import ReportInput


@dataclass(frozen=True)
class Section:
    """A section, one of the `SECTIONS` that a module of `rigrunner_reports.view` declares.

    Its template is `templates/NAME.html.j2`, which is given what `view` returned as `view`.
    """

    name: str
    """Of its template, and its anchor in the page."""
    title: str
    """In the contents."""
    place: int
    """Sections stand in this order, from 0, the result, to 120, what made the report."""
    view: Callable[[ReportInput, Any], object]
    """Returns what the section shows, of the report's input and its page; nothing leaves it out."""
    unbroken: bool = False
    """Whether each number keeps its unit beside it on one line."""
    anchor: str = ""
    """In the page, where it is not the name."""
