"""Which sections a report has, in their order."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from rigrunner_reports import view
from rigrunner_reports.section import Section

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.results import ReportInput
    from rigrunner_reports.page import Page

RIG = "The rig\N{RIGHT SINGLE QUOTATION MARK}s part"
OF_THE_PAGE = (
    Section("result", "Result", 0, lambda _, page: page, unbroken=True),
    Section("rig", RIG, 20, lambda _, page: page.fits and not page.methods),
    Section("frequency", "Every set-point", 30, lambda _, page: page.table.rows),
    Section("swing", "Inside a swing", 40, lambda _, page: page.figures.over_phase),
    Section("methods", "Methods", 50, lambda _, page: page.methods),
    Section("rig", RIG, 60, lambda _, page: page.fits and page.methods),
    Section("uncertainty", "Uncertainty", 70, lambda _, page: page.budget),
    Section("checks", "Checks", 80, lambda _, page: page.table.rows or page.checks),
    Section("cycles", "Cycles", 90, lambda _, page: page.table.rows),
    Section("motion", "Motion", 100, lambda _, page: page.figures.motion),
    Section("run", "The run", 110, lambda _, page: page),
    Section("provenance", "Provenance", 120, lambda _, page: page),
)
"""Those that show parts of the page; of the two places of one name, one is ever taken."""


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
    declared = [vars(each)["SECTION"] for each in modules if "SECTION" in vars(each)]
    return tuple(sorted((*OF_THE_PAGE, *declared), key=lambda each: each.place))
