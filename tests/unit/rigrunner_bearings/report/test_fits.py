from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from rigrunner.api.analysis import Candidate
from rigrunner_bearings.report.view.fits import CandidateView, fit_views
from rigrunner_reports.render import html
from unit.rigrunner_reports.helpers_html import read_html
from unit.rigrunner_reports.helpers_report import (
    PolynomialCurve,
    changed,
    no_load_result,
    report_input,
    torque_of,
)

CANDIDATES = (
    Candidate("T = c0 + c1·f + c2·f²", 3, -30.158, 0.050629, chosen=True),
    Candidate("T = c0 + c2·f²", 2, -19.683, 0.159397),
    Candidate("T = c0 + c8·f⁸", 9, float("nan"), float("nan"), problem="9 points are too few"),
)


@dataclass(frozen=True, eq=False)
class ChosenCurve(PolynomialCurve):
    criterion: str = "AICc"
    candidates: tuple[Candidate, ...] = CANDIDATES


@pytest.fixture(scope="module")
def result():
    base = no_load_result()
    curve = ChosenCurve(**vars(torque_of(base).fits[0].curve))
    return changed(
        base,
        fits=(replace(torque_of(base).fits[0], name="aicc", curve=curve), torque_of(base).fits[1]),
    )


def test_chosen_fit_lists_its_candidates(result):
    chosen, fixed_form = fit_views(torque_of(result).fits)
    assert chosen.criterion == "AICc"
    assert chosen.candidates[:2] == (
        CandidateView("T = c0 + c1·f + c2·f²", "50.6", "−30.2", chosen=True, problem=""),  # noqa: RUF001  (a minus sign)
        CandidateView("T = c0 + c2·f²", "159", "−19.7", chosen=False, problem=""),  # noqa: RUF001  (a minus sign)
    )
    assert fixed_form.candidates == ()


def test_report_has_table_of_candidates(result):
    words = read_html(html(report_input(result))).words
    assert "the lowest AICc is the best" in words
    assert "T = c0 + c1·f + c2·f² 50.6 −30.2 chosen T = c0 + c2·f² 159 −19.7 T" in words  # noqa: RUF001  (a minus sign)
    assert "not fitted: 9 points are too few" in words


def test_fixed_fit_has_no_table_of_candidates():
    words = read_html(html(report_input(no_load_result()))).words
    assert "lowest AICc" not in words
