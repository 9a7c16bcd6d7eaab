"""Which sections a report has, in their order."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from rigrunner_reports import view

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.results import ReportInput
    from rigrunner_reports.page import Page
    from rigrunner_reports.section import Section


def contents(report: ReportInput, page: Page) -> Iterator[tuple[Section, object]]:
    """Yield each section of a report with what it shows; those that show nothing are left out."""
    for section in _sections():
        shown = section.view(report, page)
        if shown:
            yield section, shown


@cache
def _sections() -> tuple[Section, ...]:
    modules = (
        import_module(f"{view.__name__}.{each.name}") for each in iter_modules(view.__path__)
    )
    declared = [each for module in modules for each in getattr(module, "SECTIONS", ())]
    return tuple(sorted(declared, key=lambda each: each.place))
