"""Assemble the parts of a report from the data of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rigrunner.api.analysis.requirements import partner_words
from rigrunner.signal.recording_figures import of_recording, of_table
from rigrunner_reports.figures.results import over_coordinate, picture_of
from rigrunner_reports.section import BELOW, TILES, installed_sections
from rigrunner_reports.view import decision as decisions
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
    overall: decisions.OverallView | None
    decision: decisions.DecisionView | None
    later_decisions: tuple[decisions.LaterView, ...]
    checks: tuple[CheckRow, ...]
    events: tuple[Mapping[str, str], ...]
    notes: tuple[str, ...]
    instruments: tuple[run.Facts, ...]
    settings: run.Facts
    provenance: run.Facts
    figures: Figures
    installed: tuple[tuple[Sections, Any], ...]
    """The sections of other packages, each with its own page."""
    inside: Mapping[str, list[tuple[Section, object]]]
    """Those inside the section of the result, with their content, by their place."""


def make_page(report: ReportInput) -> Page:
    """Return the page of a report."""
    result = report.result
    pages = ((sections, sections.page(report)) for sections in installed_sections())
    others = [(sections, page) for sections, page in pages if page is not None]
    numbers = (number for sections, page in others if (number := sections.headline(report, page)))
    inside: dict[str, list[tuple[Section, object]]] = {TILES: [], BELOW: []}
    for sections, page in others:
        for section in sections.sections:
            if section.inside and (shown := section.view(report, page)):
                inside[section.inside].append((section, shown))
    warnings = run.warnings(result)
    decision = None
    if result.decision is not None:
        decision = decisions.DecisionView(result.decision, complete=not warnings)
    return Page(
        title=result.run.procedure_title,
        run_id=result.run.run_id,
        simulated=bool(report.truth),
        facts=run.facts(result),
        restrictions=(*run.replay_warning(report.provenance), *run.restrictions(result)),
        overrides=run.overrides(report.events),
        warnings=warnings,
        imported=run.import_notes(result),
        headline=next(numbers, None) or headline(result),
        overall=decisions.overall(result, report.later_decisions),
        decision=decision,
        later_decisions=tuple(map(decisions.LaterView, report.later_decisions)),
        checks=check_rows(result),
        events=run.shown_events(report.events),
        notes=result.notes,
        instruments=instruments(result.run),
        settings=run.settings(result),
        provenance=_provenance(report),
        figures=Figures(
            results=_result_pictures(result),
            tables={
                name: picture
                for name, rows in unlimited_tables(result).items()
                if (picture := of_table(rows)) is not None
            },
            recordings=tuple(map(of_recording, drawn_recordings(result))),
        ),
        installed=tuple(others),
        inside=inside,
    )


def _provenance(report: ReportInput) -> run.Facts:
    run = report.result.run
    partners = {partner_words(name): partner for name, partner in run.partners.items()}
    runs = {"run": run, **partners}
    listed = set(report.provenance.values())
    digests = tuple(
        (f"{name[0].upper()}{name[1:]}, SHA-256 of the recordings", data.digest)
        for name, data in runs.items()
        if data.digest and data.digest not in listed
    )
    return (*digests, *report.provenance.items())


def _result_pictures(result: Result) -> dict[str, tuple[Picture, ...]]:
    parts = result.decision.parts if result.decision else ()
    pictures = {}
    every = (*result.other_results, *result.missing)
    for name in dict.fromkeys(item.name for item in every):
        results = [named for named in result.other_results if named.name == name]
        pictures[name] = (
            *over_coordinate(results, [part for part in parts if part.named == name]),
            *(picture_of(figure) for figure in result.figures if figure.of == name),
        )
    return pictures
