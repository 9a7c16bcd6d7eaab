"""The sections of a report, in order."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from rigrunner.api.figures import Figure
from rigrunner_reports import view
from rigrunner_reports.figures.results import given
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


def contents(report: ReportInput, page: Page) -> Iterator[tuple[Section, object]]:
    """Yield each section of a report with its content; empty ones are left out."""
    found: list[tuple[Section, Any]] = [(each, page) for each in _sections()]
    for number, given_section in enumerate(report.result.sections, 1):
        # Those of analyses come after the results, at 5.
        title, shown = given_section.title, given_view(given_section)
        # `v` holds this section's own: the function is called after the loop.
        own = Section("given", title, 6, lambda *_, v=shown: v, anchor=f"given-{number}")
        found.append((own, page))
    for sections, of in page.brought:
        found += [(each, of) for each in sections.sections if not each.inside]
    for section, of in sorted(found, key=lambda each: each[0].place):
        if content := section.view(report, of):
            yield section, content


@cache
def _sections() -> tuple[Section, ...]:
    modules = (
        import_module(f"{view.__name__}.{each.name}") for each in iter_modules(view.__path__)
    )
    declared = [each for module in modules for each in getattr(module, "SECTIONS", ())]
    return tuple(sorted(declared, key=lambda each: each.place))
