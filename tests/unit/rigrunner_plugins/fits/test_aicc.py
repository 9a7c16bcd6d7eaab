from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner_plugins.fits.polynomial import AiccFit, BasisFit
from rigrunner_plugins.fits.settings import AiccSettings, BasisSettings

X = np.array([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0])
Y = np.array([0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91])


def fit(points, **changes):
    return AiccFit(AiccSettings(**changes))(points)


def chosen(curve):
    return [candidate.formula for candidate in curve.candidates if candidate.chosen]


def test_chosen_curve_equals_the_basis_fit_of_its_powers():
    curve = fit(Points(X, Y))
    basis = BasisFit(BasisSettings(powers=[0, 1, 4]))(Points(X, Y))
    assert curve.coefficients.tolist() == basis.coefficients.tolist()
    assert curve.covariance.tolist() == basis.covariance.tolist()
    assert chosen(curve) == [curve.formula] == [basis.formula]


@pytest.mark.parametrize("y", [1 + 0.5 * X, 7 + 0.125 * X, 3e-9 * X, np.full(8, 0.3), np.zeros(8)])
def test_simplest_of_exact_candidates_is_chosen(y):
    assert chosen(fit(Points(X, y), candidates=[[0, 1, 2], [0, 1], [0, 1, 2, 3]])) == [
        "T = c0 + c1·f"
    ]


def test_tie_goes_to_the_first_candidate():
    assert chosen(fit(Points(X, np.zeros(8)), candidates=[[0, 3], [0, 2]])) == ["T = c0 + c3·f³"]


def test_weights_decide_the_choice():
    """A line except for three points of very large uncertainty."""
    y = 1 + 0.1 * X + np.array([0.0, 0.01, -0.01, 0.01, -0.01, 0.3, 0.6, 1.2])
    u_y = np.array([0.01] * 5 + [10.0] * 3)
    candidates = [[0, 1], [0, 1, 2]]
    assert chosen(fit(Points(X, y, u_y), candidates=candidates)) == ["T = c0 + c1·f + c2·f²"]
    weighted = fit(Points(X, y, u_y), candidates=candidates, weighted=True)
    assert chosen(weighted) == ["T = c0 + c1·f"]


def test_candidate_that_cannot_be_fitted_says_why():
    curve = fit(Points(X[:6], Y[:6]))
    assert [candidate.problem for candidate in curve.candidates] == [
        "", "", "", "AICc of 4 coefficients needs 7 points, got 6",
    ]  # fmt: skip
    assert np.isnan(curve.candidates[3].score)
    assert len(chosen(curve)) == 1


def test_no_fitted_candidate_is_an_error():
    with pytest.raises(DataError, match=r"no candidate can be fitted: AICc of 3 .* needs 6 points"):
        fit(Points(X[:5], Y[:5]), candidates=[[0, 1, 2], [0, 1, 2, 3]])


@pytest.mark.parametrize(
    ("candidates", "message"),
    [
        ([], "at least 1 item"),
        ([[]], "at least 1 item"),
        ([[0, 1], [1, 0]], "is listed 2 times"),
        ([[0, 1], [2, 2]], "2 is listed 2 times"),
        ([0, 1], "valid tuple"),
    ],
)
def test_invalid_settings_are_refused(candidates, message):
    with pytest.raises(ValidationError, match=message):
        AiccSettings(candidates=candidates)
