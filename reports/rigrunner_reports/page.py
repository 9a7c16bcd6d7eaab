"""Puts the parts of a report together: what is shown depends on what the run has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.torque import TorqueDetails
from rigrunner.signal.recording_figures import of_recording, of_table
from rigrunner_reports.figures.cycles import cycle_values
from rigrunner_reports.figures.fits import fitted_peaks
from rigrunner_reports.figures.frequency import over_frequency
from rigrunner_reports.figures.kinematics import motion
from rigrunner_reports.figures.results import given, over_coordinate
from rigrunner_reports.figures.swing import compensated_swings, loops, over_phase, recorded_swings
from rigrunner_reports.view import decision as decided
from rigrunner_reports.view import headline as head
from rigrunner_reports.view import run
from rigrunner_reports.view.budget import budget
from rigrunner_reports.view.checks import check_rows
from rigrunner_reports.view.cycles import named_runs, rejections
from rigrunner_reports.view.fits import fit_views
from rigrunner_reports.view.frequency_table import frequency_table
from rigrunner_reports.view.instruments import instruments
from rigrunner_reports.view.meaning import meaning
from rigrunner_reports.view.methods import methods
from rigrunner_reports.view.paper import paper_on_this_run
from rigrunner_reports.view.points import by_frequency, set_points
from rigrunner_reports.view.recorded import MOST_RECORDINGS, unlimited_tables
from rigrunner_reports.view.validation import validation

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import ReportInput
    from rigrunner.api.figures import Picture
    from rigrunner.api.results import Result
    from rigrunner_reports.view.budget import Budget
    from rigrunner_reports.view.checks import CheckRow
    from rigrunner_reports.view.cycles import RejectionTable
    from rigrunner_reports.view.fits import FitView
    from rigrunner_reports.view.frequency_table import FrequencyTable
    from rigrunner_reports.view.methods import MethodView
    from rigrunner_reports.view.points import SetPoint
    from rigrunner_reports.view.validation import ValidationView


@dataclass(frozen=True)
class Figures:
    """The pictures; None where the run has nothing to plot."""

    over_frequency: Picture | None
    over_phase: Picture | None
    loops: Picture | None
    fits: Picture | None
    cycles: Picture | None
    motion: Picture | None
    results: Mapping[str, tuple[Picture, ...]]
    """Of named results, by their name."""
    tables: Mapping[str, Picture]
    """Of tables without limits, by their name."""
    recordings: tuple[Picture, ...]
    """Of a run whose torque is not analysed."""


@dataclass(frozen=True)
class Page:
    """All that the template shows."""

    title: str
    run_id: str
    simulated: bool
    facts: run.Facts
    restrictions: tuple[str, ...]
    overrides: tuple[str, ...]
    warnings: tuple[str, ...]
    imported: tuple[str, ...]
    headline: head.Headline
    raw: head.Raw | None
    overall: decided.OverallView | None
    decision: decided.DecisionView | None
    later_decisions: tuple[decided.LaterView, ...]
    truth: head.Truth | None
    meaning: tuple[str, ...]
    table: FrequencyTable
    methods: tuple[MethodView, ...]
    paper: tuple[str, ...]
    fits: tuple[FitView, ...]
    budget: Budget | None
    validation: ValidationView | None
    checks: tuple[CheckRow, ...]
    rejections: RejectionTable
    events: tuple[Mapping[str, str], ...]
    notes: tuple[str, ...]
    instruments: tuple[run.Facts, ...]
    settings: run.Facts
    provenance: run.Facts
    figures: Figures


def make_page(report: ReportInput) -> Page:
    """Return the page of a report."""
    result, points = report.result, set_points(report)
    torque = TorqueDetails.of(result)
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
        headline=head.headline(result, points),
        raw=head.raw(torque),
        overall=decided.overall(result, report.later_decisions),
        decision=decision,
        later_decisions=tuple(map(decided.LaterView, report.later_decisions)),
        truth=head.truth(torque, points),
        meaning=meaning(torque) if points else (),
        table=frequency_table(torque, points),
        methods=methods(torque, points),
        paper=paper_on_this_run(torque, points),
        fits=fit_views(torque.fits),
        budget=budget(torque, points),
        validation=validation(torque),
        checks=check_rows(result),
        rejections=rejections(torque),
        events=run.shown_events(report.events),
        notes=result.notes,
        instruments=instruments(result.run),
        settings=run.settings(result),
        provenance=_provenance(report),
        figures=_figures(result, points),
    )


def _provenance(report: ReportInput) -> run.Facts:
    runs = (("Run", report.result.run), ("No-load run", report.result.no_load_run))
    told = set(report.provenance.values())
    digests = tuple(
        (f"{name}, SHA-256 of the recordings", each.digest)
        for name, each in runs
        if each is not None and each.digest and each.digest not in told
    )
    return (*digests, *report.provenance.items())


def _figures(result: Result, points: Sequence[SetPoint]) -> Figures:
    torque = TorqueDetails.of(result)
    compensated = any(each.by_method for each in points)
    swings = compensated_swings(points, torque.primary) or recorded_swings(points)
    fitted = any(fit.curve is not None for fit in torque.fits)
    fastest = [each.swing for each in by_frequency(points) if each.swing][-1:]
    several = any(each.point.cycles > 1 for each in points)
    return Figures(
        over_frequency=over_frequency(result, points) if compensated else None,
        over_phase=over_phase(swings) if swings else None,
        loops=loops(swings) if swings else None,
        fits=fitted_peaks(torque.fits) if fitted else None,
        cycles=cycle_values(named_runs(torque)) if several else None,
        motion=motion(fastest[0], result.run.rig.eccentric_ratio) if fastest else None,
        results=_named(result),
        tables={
            name: picture
            for name, rows in unlimited_tables(result).items()
            if (picture := of_table(rows)) is not None
        },
        recordings=()
        if torque.loaded
        else tuple(map(of_recording, result.run.recordings[:MOST_RECORDINGS])),
    )


def _named(result: Result) -> dict[str, tuple[Picture, ...]]:
    parts = result.decision.parts if result.decision else ()
    pictures = {}
    for name in dict.fromkeys(each.name for each in result.other_results):
        found = [each for each in result.other_results if each.name == name]
        pictures[name] = (
            *over_coordinate(found, [part for part in parts if part.named == name]),
            *(given(each) for each in result.figures if each.of == name),
        )
    return pictures
