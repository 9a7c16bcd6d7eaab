"""Sections that analyses give as data, ready to print."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.figures import Figure
from rigrunner_reports.figures.results import given
from rigrunner_reports.mathematics import equation
from rigrunner_reports.view.results import table_view

if TYPE_CHECKING:
    from markupsafe import Markup

    from rigrunner.api.figures import Picture
    from rigrunner.api.findings import ReportSection
    from rigrunner_reports.view.results import TableView


@dataclass(frozen=True)
class GivenView:
    """A section of an analysis."""

    title: str
    paragraphs: tuple[str, ...]
    formulas: tuple[Markup, ...]
    pictures: tuple[Picture, ...]
    tables: tuple[TableView, ...]


def given_view(section: ReportSection) -> GivenView:
    """Return a section, ready to print."""
    return GivenView(
        title=section.title,
        paragraphs=section.paragraphs,
        formulas=tuple(map(equation, section.formulas)),
        pictures=tuple(
            given(each) if isinstance(each, Figure) else each for each in section.figures
        ),
        tables=tuple(map(table_view, section.tables)),
    )
