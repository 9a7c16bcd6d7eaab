"""The sections of a report, in order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from rigrunner.api.figures import Figure
from rigrunner_reports import view
from rigrunner_reports.figures.results import picture_of
from rigrunner_reports.mathematics import equation
from rigrunner_reports.section import Section
from rigrunner_reports.view.results import table_view

if TYPE_CHECKING:
    from collections.abc import Iterator

    from markupsafe import Markup

    from rigrunner.api import ReportInput
    from rigrunner.api.figures import Picture
    from rigrunner.api.findings import ReportSection
    from rigrunner_reports.page import Page
    from rigrunner_reports.view.results import TableView


@dataclass(frozen=True)
class SectionView:
    """A section of an analysis."""

    title: str
    paragraphs: tuple[str, ...]
    formulas: tuple[Markup, ...]
    pictures: tuple[Picture, ...]
    tables: tuple[TableView, ...]


def section_view(section: ReportSection) -> SectionView:
    """Return a section, ready to print."""
    return SectionView(
        title=section.title,
        paragraphs=section.paragraphs,
        formulas=tuple(map(equation, section.formulas)),
        pictures=tuple(
            picture_of(figure) if isinstance(figure, Figure) else figure
            for figure in section.figures
        ),
        tables=tuple(map(table_view, section.tables)),
    )


def contents(report: ReportInput, page: Page) -> Iterator[tuple[Section, object]]:
    """Yield each section of a report with its content; empty ones are left out."""
    chosen: list[tuple[Section, Any]] = [(section, page) for section in _sections()]
    for number, given_section in enumerate(report.result.sections, 1):
        # Those of analyses come after the results, at 5.
        title, shown = given_section.title, section_view(given_section)
        # `v` holds this section's own: the function is called after the loop.
        entry = Section("given", title, 6, lambda *_, v=shown: v, anchor=f"given-{number}")
        chosen.append((entry, page))
    for sections, own_page in page.installed:
        chosen += [(section, own_page) for section in sections.sections if not section.inside]
    for section, own_page in sorted(chosen, key=lambda item: item[0].place):
        if content := section.view(report, own_page):
            yield section, content


@cache
def _sections() -> tuple[Section, ...]:
    modules = (
        import_module(f"{view.__name__}.{info.name}") for info in iter_modules(view.__path__)
    )
    declared = [section for module in modules for section in getattr(module, "SECTIONS", ())]
    return tuple(sorted(declared, key=lambda section: section.place))
