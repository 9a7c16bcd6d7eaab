"""The sections of a report, in order."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from rigrunner_reports import view
from rigrunner_reports.given import given_view
from rigrunner_reports.section import Section

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import ReportInput
    from rigrunner_reports.page import Page


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
