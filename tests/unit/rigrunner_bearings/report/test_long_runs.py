"""Reports of long runs have a bounded size and keep all extremes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rigrunner.signal.thinning import places_of_extremes
from rigrunner_bearings.report.figures import cycles
from rigrunner_bearings.report.page import torque_page
from rigrunner_bearings.report.view.cycles import MOST_ROWS, rejections
from rigrunner_reports.figures.results import MOST_POINTS, THINNED
from rigrunner_reports.render import html
from rigrunner_reports.view.run import shown_events
from unit.rigrunner_reports.helpers_report import (
    changed,
    loaded_result,
    long_result,
    report_input,
    torque_of,
)

pytestmark = pytest.mark.figures

MOST_BYTES = 1_500_000
EVENTS = tuple({"utc": f"{i}", "kind": "alarm", "text": f"no {i}"} for i in range(500))

some_values = arrays(
    float,
    st.integers(1, 300),
    elements=st.one_of(st.floats(allow_nan=False), st.sampled_from([0.0, 1.0])),
)


@given(values=some_values, most=st.integers(2, 80))
def test_thinning_keeps_extremes(values, most):
    shown = places_of_extremes(values, most=most)
    assert len(shown) <= most or len(shown) == len(values) <= most
    assert list(shown) == sorted(set(shown))
    assert values[shown].min() == values.min()
    assert values[shown].max() == values.max()


@given(values=some_values, most=st.integers(2, 80))
def test_each_part_keeps_its_extremes(values, most):
    """Each of the equal parts of a run shows its own extremes."""
    shown = set(places_of_extremes(values, most=most))
    parts = most // 2 if len(values) > most else len(values)
    for part in range(parts):
        start, end = (int(len(values) * (part + more) / parts) for more in (0, 1))
        kept = [values[place] for place in range(start, end) if place in shown]
        assert (min(kept), max(kept)) == (values[start:end].min(), values[start:end].max())


def test_few_values_are_all_shown():
    assert list(places_of_extremes(np.zeros(7), most=7)) == list(range(7))
    assert list(places_of_extremes(np.zeros(0), most=7)) == []


def test_nan_is_never_an_extreme():
    values = np.array([np.nan, 3.0, np.nan, 1.0, 2.0, np.nan])
    assert list(places_of_extremes(values, most=2)) == [1, 3]


def test_each_series_keeps_its_extremes():
    rising, spiked = np.arange(100.0), np.zeros(100)
    spiked[[37, 61]] = 5.0, -5.0
    shown = places_of_extremes(rising, spiked, most=4)
    assert {0, 99, 37, 61} <= set(shown)


@pytest.fixture(scope="module")
def hours():
    return long_result(points=12, cycles=4000, rejected=300)


@pytest.fixture(scope="module")
def many_set_points():
    return long_result(points=400, cycles=10, rejected=1)


@pytest.mark.thorough
def test_report_size_does_not_grow_with_number_of_swings(hours):
    twice = long_result(points=12, cycles=8000, rejected=600)
    sizes = [len(html(report_input(result))) for result in (hours, twice)]
    assert max(sizes) < MOST_BYTES
    assert sizes[1] < 1.02 * sizes[0]


@pytest.mark.thorough
def test_report_size_is_bounded_for_hundreds_of_set_points(many_set_points):
    assert len(html(report_input(many_set_points))) < MOST_BYTES


def test_single_high_peak_in_long_run_is_drawn(hours):
    point = torque_of(hours).loaded[3]
    peaks = point.peak_nm.copy()
    peaks[np.flatnonzero(point.peak_kept)[1234]] += 50.0
    heights = sorted(kept_marks((*torque_of(hours).loaded[:3], replace(point, peak_nm=peaks))))
    assert heights[-1] > 40_000  # mN·m; all others are far below
    assert heights[-2] < 10_000


def kept_marks(points):
    """Return the heights of the kept peaks that are drawn."""
    (panel,) = cycles.cycle_values([("This run", points)]).panels
    return [p.y for series in panel.series if series.name == "peak kept" for p in series.points]


def test_caption_mentions_thinning_only_if_thinned(hours):
    few, many = (
        cycles.cycle_values([("x", torque_of(result).loaded)])
        for result in (loaded_result(), hours)
    )
    assert [cycles.THINNED in picture.caption for picture in (few, many)] == [False, True]
    assert few.caption == many.caption.removesuffix(cycles.THINNED)


@pytest.mark.thorough
def test_figures_of_many_set_points_mention_thinning(many_set_points):
    page = torque_page(report_input(many_set_points))
    for plot in (page.figures.over_frequency, page.figures.fits):
        assert plot.caption.endswith(THINNED)
        assert plot.alt.count(" Hz ") <= MOST_POINTS * 5
    assert len(page.table.rows) == 400
    assert "peaks kept: 3600 of 4000" in page.figures.cycles.alt


def test_clearest_rejections_are_listed_and_others_counted(hours):
    table = rejections(torque_of(hours))
    ratios = [
        rejection.statistic / rejection.critical
        for run in (torque_of(hours).loaded, torque_of(hours).no_load)
        for point in run
        for rejection in (*point.peak_rejections, *point.waveform_rejections)
    ]
    assert len(table.rows) == MOST_ROWS
    assert len(table.rows) + table.left_out == len(ratios)
    listed = [float(row.statistic) / float(row.critical) for row in table.rows]
    assert min(listed) >= sorted(ratios)[-MOST_ROWS] - 0.01


@pytest.mark.thorough
def test_page_states_number_of_omitted_rows(hours):
    text = html(report_input(hours, events=EVENTS)).decode()
    assert f"{rejections(torque_of(hours)).left_out} more were rejected" in text
    assert "200 more: 200 of kind &#39;alarm&#39;; run.log has all" in text


def test_rejection_without_critical_value_is_shown():
    result = loaded_result()
    point = next(point for point in torque_of(result).loaded if point.peak_rejections)
    rejection = replace(point.peak_rejections[0], critical=0.0)
    point = replace(point, peak_rejections=(rejection,))
    assert rejections(torque_of(changed(result, loaded=(point,)))).rows[0].critical == "0"


@pytest.mark.parametrize(("count", "shown"), [(3, 3), (300, 300), (301, 301), (500, 301)])
def test_first_and_last_of_many_events_are_shown(count, shown):
    events = EVENTS[:count]
    listed = shown_events(events)
    assert len(listed) == shown
    assert (listed[0], listed[-1]) == (events[0], events[-1])
    gaps = [event["text"] for event in listed if event["kind"] == "more"]
    left_out = count - 300
    expected = f"{left_out} more: {left_out} of kind 'alarm'; run.log has all"
    assert gaps == ([expected] if left_out > 0 else [])
