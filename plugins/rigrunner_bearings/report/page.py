"""Puts together what the report shows of torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.report.figures.cycles import cycle_values
from rigrunner_bearings.report.figures.fits import fitted_peaks
from rigrunner_bearings.report.figures.frequency import over_frequency
from rigrunner_bearings.report.figures.kinematics import motion
from rigrunner_bearings.report.figures.swing import (
    compensated_swings,
    loops,
    over_phase,
    recorded_swings,
)
from rigrunner_bearings.report.view import headline as head
from rigrunner_bearings.report.view.budget import budget
from rigrunner_bearings.report.view.cycles import named_runs, rejections
from rigrunner_bearings.report.view.fits import RIG, fit_views
from rigrunner_bearings.report.view.frequency_table import frequency_table
from rigrunner_bearings.report.view.meaning import meaning
from rigrunner_bearings.report.view.methods import methods
from rigrunner_bearings.report.view.paper import paper_on_this_run
from rigrunner_bearings.report.view.points import by_frequency, set_points
from rigrunner_bearings.report.view.validation import validation
from rigrunner_reports.section import BELOW, TILES, Headline, Section, Sections

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api import ReportInput
    from rigrunner.api.figures import Picture
    from rigrunner.api.results import Result
    from rigrunner_bearings.report.view.budget import Budget
    from rigrunner_bearings.report.view.cycles import RejectionTable
    from rigrunner_bearings.report.view.fits import FitView
    from rigrunner_bearings.report.view.frequency_table import FrequencyTable
    from rigrunner_bearings.report.view.methods import MethodView
    from rigrunner_bearings.report.view.points import SetPoint
    from rigrunner_bearings.report.view.validation import ValidationView


@dataclass(frozen=True)
class Figures:
    """The pictures; None where the run has nothing to plot."""

    over_frequency: Picture | None
    over_phase: Picture | None
    loops: Picture | None
    fits: Picture | None
    cycles: Picture | None
    motion: Picture | None


@dataclass(frozen=True)
class TorquePage:
    """All that the templates show of torque."""

    label: str
    headline: Headline | None
    raw: head.Raw | None
    truth: head.Truth | None
    meaning: tuple[str, ...]
    table: FrequencyTable
    methods: tuple[MethodView, ...]
    paper: tuple[str, ...]
    fits: tuple[FitView, ...]
    budget: Budget | None
    validation: ValidationView | None
    rejections: RejectionTable
    figures: Figures


def torque_page(report: ReportInput) -> TorquePage | None:
    """Return what the report shows of torque; None of a run that has none."""
    result, points = report.result, set_points(report)
    torque = result.details_of(TorqueDetails)
    if torque is None:
        return None
    return TorquePage(
        label=result.measurand,
        headline=head.headline(result, points),
        raw=head.raw(torque),
        truth=head.truth(torque, points),
        meaning=meaning(torque) if points else (),
        table=frequency_table(torque, points),
        methods=methods(torque, points),
        paper=paper_on_this_run(torque, points),
        fits=fit_views(torque.fits),
        budget=budget(torque, points),
        validation=validation(torque),
        rejections=rejections(torque),
        figures=_figures(result, points),
    )


def _figures(result: Result, points: Sequence[SetPoint]) -> Figures:
    torque = TorqueDetails.of(result)
    compensated = any(set_point.by_method for set_point in points)
    swings = compensated_swings(points, torque.primary) or recorded_swings(points)
    fitted = any(fit.curve is not None for fit in torque.fits)
    fastest = [set_point.swing for set_point in by_frequency(points) if set_point.swing][-1:]
    several = any(set_point.point.cycles > 1 for set_point in points)
    return Figures(
        over_frequency=over_frequency(result, points) if compensated else None,
        over_phase=over_phase(swings) if swings else None,
        loops=loops(swings) if swings else None,
        fits=fitted_peaks(torque.fits) if fitted else None,
        cycles=cycle_values(named_runs(torque)) if several else None,
        motion=motion(fastest[0], rig_of(result.run).eccentric_ratio) if fastest else None,
    )


def _section(
    name: str, title: str, place: int, shown: Callable[[TorquePage], object], inside: str = ""
) -> Section:
    """Return a section that is given the page of the torque where there is something to show."""
    return Section(
        name,
        title,
        place,
        lambda _, page: page if shown(page) else None,
        inside=inside,
        package=__name__.rpartition(".")[0],
    )


SECTIONS = Sections(
    page=torque_page,
    headline=lambda _, page: page.headline,
    sections=(
        _section("raw", "", 40, lambda page: page.raw, TILES),
        _section("truth", "", 60, lambda page: page.truth, TILES),
        _section("meaning", "", 0, lambda page: page.figures.over_frequency or page.meaning, BELOW),
        # before the set-points where there is no method
        _section("rig", RIG, 20, lambda page: page.fits and not page.methods),
        _section("frequency", "Every set-point", 30, lambda page: page.table.rows),
        _section("swing", "Inside a swing", 40, lambda page: page.figures.over_phase),
        _section("methods", "Methods", 50, lambda page: page.methods),
        _section("rig", RIG, 60, lambda page: page.fits and page.methods),
        _section("uncertainty", "Uncertainty", 70, lambda page: page.budget),
        _section("cycles", "Cycles", 90, lambda page: page.table.rows),
        _section("motion", "Motion", 100, lambda page: page.figures.motion),
    ),
)
