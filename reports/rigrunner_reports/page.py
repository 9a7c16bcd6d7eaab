"""Assemble the parts of a report from the data of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.signal.recording_figures import of_recording, of_table
from rigrunner_reports.figures.results import given, over_coordinate
from rigrunner_reports.section import BELOW, TILES, brought
from rigrunner_reports.view import decision as decided
from rigrunner_reports.view import run
from rigrunner_reports.view.checks import check_rows
from rigrunner_reports.view.headline import headline
from rigrunner_reports.view.instruments import instruments
from rigrunner_reports.view.recorded import drawn_recordings, unlimited_tables

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import ReportInput
    from rigrunner.api.figures import Picture
    from rigrunner.api.results import Result
    from rigrunner_reports.section import Headline, Section, Sections
    from rigrunner_reports.view.checks import CheckRow


@dataclass(frozen=True)
class Figures:
    """The figures; none if the run has nothing to plot."""

    results: Mapping[str, tuple[Picture, ...]]
    """Figures of named results, by their name."""
    tables: Mapping[str, Picture]
    """Figures of tables without limits, by their name."""
    recordings: tuple[Picture, ...]
    """Figures of recordings that no analysis shows."""


@dataclass(frozen=True)
class Page:
    """All that the templates show, except the content of other packages."""

    title: str
    run_id: str
    simulated: bool
    facts: run.Facts
    restrictions: tuple[str, ...]
    overrides: tuple[str, ...]
    warnings: tuple[str, ...]
    imported: tuple[str, ...]
    headline: Headline
    overall: decided.OverallView | None
    decision: decided.DecisionView | None
    later_decisions: tuple[decided.LaterView, ...]
    checks: tuple[CheckRow, ...]
    events: tuple[Mapping[str, str], ...]
    notes: tuple[str, ...]
    instruments: tuple[run.Facts, ...]
    settings: run.Facts
    provenance: run.Facts
    figures: Figures
    brought: tuple[tuple[Sections, Any], ...]
    """The sections of other packages, each with its own page."""
    inside: Mapping[str, list[tuple[Section, object]]]
    """Those inside the section of the result, with their content, by their place."""


def make_page(report: ReportInput) -> Page:
    """Return the page of a report."""
    result = report.result
    others = [(each, page) for each in brought() if (page := each.page(report)) is not None]
    numbers = (found for each, page in others if (found := each.headline(report, page)))
    inside: dict[str, list[tuple[Section, object]]] = {TILES: [], BELOW: []}
    for sections, page in others:
        for each in sections.sections:
            if each.inside and (shown := each.view(report, page)):
                inside[each.inside].append((each, shown))
    warnings = run.warnings(result)
    decision = None
    if result.decision is not None:
        decision = decided.DecisionView(result.decision, complete=not warnings)
    return Page(
        title=result.run.procedure_title,
        run_id=result.run.run_id,
        simulated=bool(report.truth),
        facts=run.facts(result),
        restrictions=(*run.replayed(report.provenance), *run.restrictions(result)),
        overrides=run.overrides(report.events),
        warnings=warnings,
        imported=run.imported(result),
        headline=next(numbers, None) or headline(result),
        overall=decided.overall(result, report.later_decisions),
        decision=decision,
        later_decisions=tuple(map(decided.LaterView, report.later_decisions)),
        checks=check_rows(result),
        events=run.shown_events(report.events),
        notes=result.notes,
        instruments=instruments(result.run),
        settings=run.settings(result),
        provenance=_provenance(report),
        figures=Figures(
            results=_named(result),
            tables={
                name: picture
                for name, rows in unlimited_tables(result).items()
                if (picture := of_table(rows)) is not None
            },
            recordings=tuple(map(of_recording, drawn_recordings(result))),
        ),
        brought=tuple(others),
        inside=inside,
    )


def _provenance(report: ReportInput) -> run.Facts:
    run = report.result.run
    partners = {partner_words(name): each for name, each in run.partners.items()}
    runs = {"run": run, **partners}
    told = set(report.provenance.values())
    digests = tuple(
        (f"{name[0].upper()}{name[1:]}, SHA-256 of the recordings", each.digest)
        for name, each in runs.items()
        if each.digest and each.digest not in told
    )
    return (*digests, *report.provenance.items())


def _named(result: Result) -> dict[str, tuple[Picture, ...]]:
    parts = result.decision.parts if result.decision else ()
    pictures = {}
    every = (*result.other_results, *result.missing)
    for name in dict.fromkeys(each.name for each in every):
        found = [each for each in result.other_results if each.name == name]
        pictures[name] = (
            *over_coordinate(found, [part for part in parts if part.named == name]),
            *(given(each) for each in result.figures if each.of == name),
        )
    return pictures
