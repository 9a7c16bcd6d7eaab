"""Consequences of a check, against the GUM computed by hand."""

from __future__ import annotations

from math import hypot, inf, sqrt

import pytest

from rigrunner.api.analysis import Bias, Check, Component, Consequence
from rigrunner.api.checks import effect_words
from rigrunner.api.data import Estimate
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation
from rigrunner_bearings.torque.binding import bind
from rigrunner_bearings.torque.headline import compensated_mean

OWN_U = 0.006


def point(hertz, *, common=False):
    part = Component("scatter", OWN_U, inf, "normal", common)
    return CompensatedPoint(hertz, hertz, 5.0, 4.2, Estimate(0.8, OWN_U), (part,))


SWEEP = Compensation("torque", tuple(point(f, common=True) for f in (5.0, 20.0, 35.0)))


def failed(*values, u=0.0, **more):
    biases = tuple(Bias(f"{f} Hz", v, u) for f, v in zip((5, 20, 35), values, strict=True))
    return Check("play", ok=False, text="it plays", advice="tighten it", biases=biases, **more)


def test_significant_bias_is_budget_line_of_points_and_mean():
    compensation, (check,) = bind(SWEEP, [failed(0.0, 0.01, 0.02, u=0.003)])
    assert (check.ok, check.consequence) == (False, Consequence.BUDGET)
    added = [hypot(v, 0.003) for v in (0.0, 0.01, 0.02)]
    for widened, more in zip(compensation.points, added, strict=True):
        assert widened.torque.u == pytest.approx(hypot(OWN_U, more))
        assert widened.components[-1].name == "play"
        assert widened.components[-1].u == pytest.approx(more)
    assert compensated_mean(compensation.points).u == pytest.approx(hypot(OWN_U, sum(added) / 3))
    assert check.biases[0] == Bias("mean", pytest.approx(0.01), pytest.approx(0.003))
    assert effect_words(check) == (
        "+0.0100 ± 0.0030 N·m on the mean, +0.0200 ± 0.0030 N·m at 35 Hz; in the budget as 'play'"
    )


def test_independent_errors_of_points_average_out():
    compensation, (check,) = bind(SWEEP, [failed(0.0, 0.0, 0.0, u=0.009, common=False)])
    assert check.consequence is Consequence.BUDGET
    assert compensated_mean(compensation.points).u == pytest.approx(hypot(OWN_U, 0.009 / sqrt(3)))


def test_effect_covered_by_budget_is_not_counted_twice():
    compensation, (check,) = bind(SWEEP, [failed(0.01, 0.01, 0.01, covered_by=("scatter",))])
    assert check.consequence is Consequence.BUDGET
    assert compensation.points[0].torque.u == pytest.approx(0.01)
    _, (note,) = bind(SWEEP, [failed(0.005, 0.005, 0.005, covered_by=("scatter",))])
    assert (note.ok, note.consequence) == (True, Consequence.NOTE)


def test_opposite_biases_cancel_in_the_mean_only():
    compensation, (check,) = bind(SWEEP, [failed(-0.02, 0.0, 0.02)])
    assert check.consequence is Consequence.BUDGET, "it matters at 35 Hz"
    assert compensated_mean(compensation.points).u == pytest.approx(OWN_U)


def test_small_bias_is_a_note_and_does_not_fail():
    compensation, (check,) = bind(SWEEP, [failed(0.001, 0.001, 0.001)])
    assert (check.ok, check.consequence) == (True, Consequence.NOTE)
    assert compensation.points == SWEEP.points
    assert effect_words(check).endswith("a note: no result moves by as much as matters")


def test_check_without_stated_effect_is_a_note():
    _, (check,) = bind(SWEEP, [Check("μ", ok=False, text="0.4")])
    assert (check.ok, check.consequence) == (True, Consequence.NOTE)


@pytest.mark.parametrize(
    "check",
    [
        failed(0.0, 0.05, 0.1),
        failed(0.0, 0.0, 0.0, u=0.05, common=False),
        Check("clipping", ok=False, text="it clips", decisive=True),
    ],
)
def test_large_or_unknown_effect_is_inconclusive(check):
    compensation, (judged,) = bind(SWEEP, [check])
    assert (judged.ok, judged.consequence) == (False, Consequence.INCONCLUSIVE)
    assert compensation.points == SWEEP.points
    assert effect_words(judged).endswith("no verdict")


def test_passed_check_states_effect_without_consequence():
    passed = Check("play", ok=True, text="none", biases=failed(0.0, 0.0, 0.003).biases)
    _, (check,) = bind(SWEEP, [passed])
    assert (check.ok, check.consequence) == (True, Consequence.NOTHING)
    assert check.biases[0].value == pytest.approx(0.001)


def test_second_check_sees_budget_line_of_first():
    second = Check(
        "slack",
        ok=False,
        text="it slacks",
        biases=failed(0.01, 0.01, 0.01).biases,
        covered_by=("play",),
    )
    compensation, checks = bind(SWEEP, [failed(0.01, 0.01, 0.01), second])
    assert [judged.consequence for judged in checks] == [Consequence.BUDGET, Consequence.NOTE]
    assert len(compensation.points[0].components) == 2
