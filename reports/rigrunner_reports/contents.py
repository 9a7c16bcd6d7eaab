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
    found: list[tuple[Section, Any]] = [(each, page) for each in (*_sections(), *_given(report))]
    for sections, own in page.brought:
        found += [(each, own) for each in sections.sections if not each.inside]
    for section, of in sorted(found, key=lambda each: each[0].place):
        shown = section.view(report, of)
        if shown:
            yield section, shown


def _given(report: ReportInput) -> Iterator[Section]:
    """Yield the sections of analyses, which come after the results."""
    for number, each in enumerate(report.result.sections, 1):
        shown = given_view(each)
        yield Section("given", each.title, 6, lambda *_, v=shown: v, anchor=f"given-{number}")


@cache
def _sections() -> tuple[Section, ...]:
    modules = (
        import_module(f"{view.__name__}.{each.name}") for each in iter_modules(view.__path__)
    )
    declared = [each for module in modules for each in getattr(module, "SECTIONS", ())]
    return tuple(sorted(declared, key=lambda each: each.place))
