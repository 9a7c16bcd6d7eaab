from __future__ import annotations

import json

import numpy as np
import pytest

from rigrunner.api.data import Points
from rigrunner.registry import load_registry
from rigrunner_bearings.api.torque import FittedTorque
from rigrunner_bearings.torque.document import fit

REGISTRY = load_registry()
POINTS = Points(
    np.array([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0]),
    np.array([0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91]),
    np.full(8, 0.01),
)


def content(name, **settings):
    curve = REGISTRY.make("fit", name, settings)(POINTS)
    return fit(FittedTorque(name, POINTS, curve))


@pytest.mark.parametrize("name", ["polynomial", "aicc", "pchip"])
def test_fit_is_json_without_nan(name):
    document = content(name)
    assert json.loads(json.dumps(document, allow_nan=False)) == document


def test_goodness_of_fit_of_paper_quadratic():
    """Residual s from RSS 0.110883 over 5 degrees of freedom; the RMSE over all 8 points."""
    curve = content("polynomial")["curve"]
    assert curve["residual_standard_deviation"] == pytest.approx((0.11088321928400216 / 5) ** 0.5)
    assert curve["root_mean_square_error"] == pytest.approx((0.11088321928400216 / 8) ** 0.5)
    assert curve["chosen_from"] is None


def test_each_point_has_curve_and_bands():
    """u(Tg) of the paper's quadratic at 10 Hz is 0.0710535; t95(5) = 2.570582."""
    at_points = content("polynomial")["at_the_points"]
    assert at_points["curve"][2] == pytest.approx(1.569065, abs=5e-7)
    assert at_points["confidence_95"][2] == pytest.approx(2.570582 * 0.0710535, rel=1e-6)
    one_more = np.hypot(0.0710535, 0.1489182455)
    assert at_points["prediction_95"][2] == pytest.approx(2.570582 * one_more, rel=1e-6)
    assert at_points["unit"] == "N·m"


def test_chosen_fit_lists_its_candidates():
    document = content("aicc", candidates=[[0, 1, 2], [0, 1, 4], [0, 1, 2, 3, 4, 5]])
    chosen_from = document["curve"]["chosen_from"]
    assert chosen_from["criterion"] == "AICc"
    assert chosen_from["candidates"][1] == {
        "formula": "T = c0 + c1·f + c4·f⁴",
        "parameters": 3,
        "score": pytest.approx(-30.2, abs=0.05),
        "residual_standard_deviation": pytest.approx(0.0506, abs=5e-5),
        "chosen": True,
        "problem": None,
    }
    assert not chosen_from["candidates"][0]["chosen"]
    assert chosen_from["candidates"][2]["score"] is None
    assert chosen_from["candidates"][2]["problem"] == "AICc of 6 coefficients needs 9 points, got 8"


def test_unknown_statistics_of_interpolation_are_null():
    document = content("pchip")
    assert document["curve"]["residual_standard_deviation"] is None
    assert document["curve"]["r_squared"] is None
    assert document["curve"]["degrees_of_freedom"] == "infinite"
    assert document["at_the_points"]["prediction_95"] == [None] * 8


def test_failed_fit_has_its_reason():
    document = fit(FittedTorque("polynomial", POINTS, None, problem="too few"))
    assert (document["curve"], document["at_the_points"], document["problem"]) == (
        None,
        None,
        "too few",
    )
