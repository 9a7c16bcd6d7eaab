"""Reports on many runs: their content, and that their size stays bounded."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from rigrunner.api.studies import Observed, Trend
from rigrunner_fleet.trends.charting import Charting, control_chart
from rigrunner_reports.studies.pictures import letter
from rigrunner_reports.studies.render import html
from rigrunner_testing.formats.studies import study_inputs
from unit.rigrunner_reports.helpers_html import read_html

pytestmark = pytest.mark.figures

MAX_BYTES = 700_000


@pytest.fixture(scope="module")
def pages():
    return [read_html(html(study)).words for study in study_inputs()]


def test_trend_shows_state_limits_and_omitted_runs(pages):
    trend = study_inputs()[0]
    (series,) = trend.series
    assert "Out of control" in pages[0]
    assert f"a rule is met at {len(series.alarms)} of {len(series.after)} runs" in pages[0]
    assert f"{series.points[-1].upper:.4f}" in pages[0]
    assert "stated U of a run: 9.0" in pages[0]
    assert "Without a chart" in pages[0]
    assert "Nelson 1 : one value beyond 3 standard deviations" in pages[0]
    assert "EWMA : the weighted mean beyond its limits" in pages[1]


def test_capability_shows_its_intervals(pages):
    (index,) = study_inputs()[2].series[0].capability.indices
    assert f"{index.value:.2f}" in pages[2]
    assert f"{index.low:.2f} to {index.high:.2f}" in pages[2]


def test_gauge_study_labels_parts_and_operators_with_letters(pages):
    study = study_inputs()[3]
    deviations = study.analysis.components
    assert f"{100 * deviations.gauge / deviations.total:.1f} %" in pages[3]
    assert f"{600 * deviations.gauge / study.tolerance:.1f}" in pages[3]
    assert "Operators: A A, B <script>" in pages[3]
    assert [letter(index) for index in (0, 25, 26, 51, 52)] == ["A", "Z", "AA", "AZ", "BA"]


def test_chart_without_runs_after_the_baseline_says_so():
    study = study_inputs()[0]
    (series,) = study.series
    points = tuple(replace(point, baseline=True) for point in series.points)
    shown = html(replace(study, series=(replace(series, points=points),)))
    assert "no run is beyond the baseline as yet" in read_html(shown).words


def test_report_on_many_runs_stays_small():
    values = np.random.default_rng(1).normal(size=20_000)
    start = datetime(2026, 1, 1, tzinfo=UTC)
    observations = [
        Observed(f"r{index}", start + timedelta(hours=index), float(value), 0.1)
        for index, value in enumerate(values)
    ]
    charting = Charting()
    series = control_chart("all", observations, charting)
    assert len(series.alarms) > 200
    study = Trend(
        quantity="torque", unit="N·m", asked={}, chart="i-mr", rules=charting.rule_texts(),
        series=(series,),
    )  # fmt: skip
    assert len(html(study)) < MAX_BYTES
