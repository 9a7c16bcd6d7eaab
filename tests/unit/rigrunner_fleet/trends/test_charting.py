"""Control charts: their limits, and warnings about the baseline."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.studies import Observed
from rigrunner_fleet.monitoring.observing import Group, Observations, study_groups
from rigrunner_fleet.monitoring.quantities import Quantity
from rigrunner_fleet.trends.charting import EWMA, MOVING_RANGE, Baseline, Charting, control_chart

START = datetime(2026, 1, 1, tzinfo=UTC)


def observed(values, expanded=None):
    return [
        Observed(f"r{index}", START + timedelta(days=index), float(value), expanded)
        for index, value in enumerate(values)
    ]


def steady(count, seed=5):
    return 10.0 + np.random.default_rng(seed).normal(size=count)


def test_values_after_the_baseline_do_not_move_limits():
    values = steady(40)
    short = control_chart("a", observed(values[:20]), Charting())
    long = control_chart("a", observed([*values[:20], *(values[20:] + 100)]), Charting())
    assert short.individuals == long.individuals
    assert short.moving_range == long.moving_range
    assert not short.after
    assert len(long.alarms) == 20


def test_baseline_of_days_may_be_anywhere():
    values = steady(40)
    days = Baseline(None, START + timedelta(days=10), START + timedelta(days=25))
    series = control_chart("a", observed(values), Charting(baseline=days))
    in_baseline = [index for index, point in enumerate(series.points) if point.baseline]
    assert in_baseline == [*range(10, 25)]
    assert series.individuals.centre == pytest.approx(values[10:25].mean())


def test_moving_range_also_detects_a_jump():
    series = control_chart("a", observed([*steady(20), 20.0]), Charting(rules="shewhart"))
    assert series.points[-1].rules == ("Nelson 1", MOVING_RANGE)
    assert series.points[-1].moving_range == pytest.approx(abs(20.0 - steady(20)[-1]))


def test_ewma_detects_a_small_shift():
    values = [*steady(20), *(steady(30, seed=9) + 1.0)]
    weighted = control_chart("a", observed(values), Charting("ewma", weight=0.1))
    single = control_chart("a", observed(values), Charting(rules="shewhart"))
    assert weighted.alarms
    assert set(weighted.alarms[0].rules) == {EWMA}
    assert len(weighted.alarms) > len(single.alarms)
    widths = [point.upper - point.lower for point in weighted.points]
    assert widths == sorted(widths)


@pytest.mark.parametrize(
    ("values", "expanded", "warning"),
    [
        (steady(12), None, "rest on 12 values"),
        (np.repeat(steady(5), 4) + 0.01 * steady(20), None, "neighbours in the baseline are corr"),
        ([*steady(19), 30.0], None, "the baseline itself meets a rule at 1 of 20"),
        (steady(20), 50.0, "narrower than the expanded uncertainty"),
    ],
)
def test_doubtful_baselines_give_warnings(values, expanded, warning):
    charting = Charting(baseline=Baseline(len(values)), rules="shewhart")
    assert warning in " ".join(control_chart("a", observed(values, expanded), charting).warnings)


def test_sound_baseline_gives_no_warning():
    assert control_chart("a", observed(steady(25), 0.5), Charting()).warnings == ()


@pytest.mark.parametrize(
    ("values", "baseline", "message"),
    [
        (steady(15), Baseline(), "there are 15 values, and the baseline is the first 20"),
        (steady(1), Baseline(), "there is 1 value"),
        (steady(30), Baseline(None, START, START + timedelta(days=5)), "of 5 values is too short"),
        ([5.0] * 20, Baseline(), "all the same"),
        ([*steady(19), np.nan], Baseline(), "not a finite number"),
    ],
)
def test_unusable_baselines_are_refused(values, baseline, message):
    with pytest.raises(DataError, match=message):
        control_chart("a", observed(values), Charting(baseline=baseline))


def test_groups_are_sorted_and_their_places_stay_in_the_order_of_the_run():
    names = ["lot B, p = 200 Pa", "lot B, p = 1000 Pa", "lot A, p = 200 Pa", "lot A, p = 1000 Pa"]
    groups = {name: Group() for name in names}
    observations = Observations(Quantity("deviation"), ("lot",), "Pa", groups, (), ())
    studies, _ = study_groups(observations, lambda name, _: name, "no chart")
    assert list(studies) == [*names[2:], *names[:2]]
