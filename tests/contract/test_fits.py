"""Properties of the shipped fits beyond the conformance kit, and their page."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigrunner.api.analysis import Chosen
from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner.registry import load_registry
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity

if TYPE_CHECKING:
    from collections.abc import Callable

REGISTRY = load_registry()
PAGE = Path(__file__).parents[2] / "docs/reference/fits.md"
X = np.array([1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 18.0, 20.0, 25.0, 30.0, 33.0, 35.0])
BETWEEN = np.array([2.0, 12.5, 19.0, 28.0, 34.0])
NOISE_NM = 0.01


def physical(frequency_hz, support=0.76, damping=0.31, inertia=0.00233):
    """Return max over the forward stroke of T0 + b omega + J alpha, by brute force."""
    phase = np.linspace(-np.pi / 2, np.pi / 2, 100_001)
    omega = angular_velocity(phase, 1.0, 2 / 45)
    alpha = angular_acceleration(phase, 1.0, 2 / 45)
    return np.array(
        [
            (support + damping * f * omega + inertia * f**2 * alpha)[omega >= 0].max()
            for f in frequency_hz
        ]
    )


@dataclass(frozen=True)
class Example:
    """A curve that the fit can follow exactly, and its coefficients."""

    truth: Callable[[np.ndarray], np.ndarray]
    coefficients: list[float]
    units: tuple[str, ...]
    settings: dict = field(default_factory=dict)
    rel: float = 1e-12
    """The relative accuracy of the truth itself."""


EXAMPLES = {
    "polynomial": Example(
        lambda f: 0.9 + 0.025 * f + 0.004 * f**2,
        [0.9, 0.025, 0.004],
        ("N·m", "N·m/Hz", "N·m/Hz²"),
    ),
    "basis": Example(
        lambda f: 0.03 * f + 2e-6 * f**4,
        [0.03, 2e-6],
        ("N·m/Hz", "N·m/Hz⁴"),
        {"powers": [4, 1]},
    ),
    "aicc": Example(
        lambda f: 1.1 + 0.0047 * f**2, [1.1, 0.0047], ("N·m", "N·m/Hz²"),
        {"candidates": [[0, 1], [0, 2], [1, 2]]},
    ),
    "expression": Example(
        lambda f: 0.9 + 0.4 * (1 - np.exp(-f / 12.0)),
        [0.9, 0.4, 12.0],
        ("N·m", "N·m", "Hz"),
        {
            "model": "T0 + a*(1 - exp(-f/f0))",
            "start": {"T0": "1 N·m", "a": "1 N·m", "f0": "20 Hz"},
        },
    ),
    "inertia_physical": Example(
        physical, [0.76, 0.31, 0.00233], ("N·m", "N·m·s/rad", "kg·m²"), rel=1e-6
    ),
    "pchip": Example(
        lambda f: 0.9 + 0.03 * f, list(0.9 + 0.03 * X), ("N·m",) * len(X)
    ),
}  # fmt: skip
FITS = sorted(EXAMPLES)
WEIGHABLE = [name for name in FITS if "weighted" in REGISTRY.settings_of("fit", name).model_fields]
WITH_INTERCEPT = sorted(set(FITS) - {"basis"})
OF_ANY_UNIT = sorted(set(FITS) - {"expression", "inertia_physical"})


def fit(name, points, **changes):
    return REGISTRY.make("fit", name, EXAMPLES[name].settings | changes)(points)


def points(name, noise=0.0, u_nm=NOISE_NM):
    return Points(X, EXAMPLES[name].truth(X) + noise, np.full(len(X), u_nm))


def noisy(name, seed=1):
    return points(name, np.random.default_rng(seed).normal(0, NOISE_NM, len(X)))


@pytest.fixture(params=FITS)
def name(request):
    return request.param


def test_every_fit_has_an_example():
    assert sorted(REGISTRY.names("fit")) == FITS


def test_fit_gives_the_known_coefficients(name):
    example = EXAMPLES[name]
    curve = fit(name, points(name))
    assert curve.coefficients == pytest.approx(example.coefficients, rel=100 * example.rel)
    assert tuple(curve.units) == example.units
    value, u = curve.predict(BETWEEN)
    assert value == pytest.approx(example.truth(BETWEEN), rel=10 * example.rel)
    assert value.shape == u.shape == BETWEEN.shape


def test_residuals_and_goodness_match_the_curve(name):
    data = noisy(name)
    curve = fit(name, data)
    value, _ = curve.predict(X)
    assert curve.residuals == pytest.approx(data.y - value, abs=1e-9)
    if name == "pchip":
        assert curve.dof == np.inf
        assert np.isnan([curve.residual_s, curve.r_squared]).all()
        return
    rss = np.sum(curve.residuals**2)
    centre = data.y.mean() if curve.names[0] in {"c0", "T0"} else 0.0
    assert curve.dof == len(X) - len(curve.coefficients)
    assert curve.residual_s == pytest.approx(np.sqrt(rss / curve.dof), rel=1e-6)
    assert curve.r_squared == pytest.approx(1 - rss / np.sum((data.y - centre) ** 2), rel=1e-9)


def test_names_units_and_covariance_are_consistent(name):
    curve = fit(name, noisy(name))
    p = len(curve.coefficients)
    assert len(curve.names) == len(set(curve.names)) == len(curve.units) == p
    assert curve.covariance.shape == (p, p)
    assert np.array_equal(curve.covariance, curve.covariance.T)
    u = np.sqrt(np.diag(curve.covariance))
    assert np.linalg.eigvalsh(curve.covariance / np.outer(u, u)).min() > 0
    assert curve.formula.startswith("T = ")


SLOW = {"expression", "inertia_physical"}
"""The kit repeats these too, with even uncertainty."""


@pytest.mark.parametrize(
    ("name", "uneven"),
    [
        *(
            pytest.param(name, False, marks=[pytest.mark.thorough] * (name in SLOW))
            for name in FITS
        ),
        *(
            pytest.param(name, True, marks=[pytest.mark.thorough] * (name in SLOW))
            for name in (*WEIGHABLE, "pchip")
        ),
    ],
)
def test_stated_uncertainty_equals_the_scatter_of_repeated_fits(name, uneven):
    """Over 400 noisy repetitions, coefficients and curve, within four standard errors: 14 %."""
    u_nm = np.linspace(0.02, 0.005, len(X)) if uneven else np.full(len(X), NOISE_NM)
    weighted = {"weighted": True} if uneven and name in WEIGHABLE else {}
    rng = np.random.default_rng(8)
    clean = EXAMPLES[name].truth(X)
    curves = [
        fit(name, Points(X, clean + rng.normal(0, u_nm), u_nm), **weighted) for _ in range(400)
    ]
    assert len({curve.formula for curve in curves}) == 1
    scatter = np.array([curve.coefficients for curve in curves]).std(axis=0, ddof=1)
    stated = np.sqrt(np.mean([np.diag(curve.covariance) for curve in curves], axis=0))
    assert stated == pytest.approx(scatter, rel=0.14)
    predicted = np.array([curve.predict(BETWEEN) for curve in curves])
    stated = np.sqrt(np.mean(predicted[:, 1] ** 2, axis=0))
    assert stated == pytest.approx(predicted[:, 0].std(axis=0, ddof=1), rel=0.14)


@pytest.mark.parametrize("name", OF_ANY_UNIT)
def test_units_follow_those_of_the_points(name):
    """In mN·m over rad/s the curve is the same curve."""
    data = noisy(name)
    converted = Points(2 * np.pi * X, 1e3 * data.y, 1e3 * data.u_y, x_unit="rad/s", y_unit="mN·m")
    value, u = fit(name, data).predict(BETWEEN)
    curve = fit(name, converted)
    other_value, other_u = curve.predict(2 * np.pi * BETWEEN)
    assert other_value == pytest.approx(1e3 * value, rel=1e-10)
    assert other_u == pytest.approx(1e3 * u, rel=1e-8)
    assert all(unit.startswith("mN·m") for unit in curve.units)
    assert all(unit == "mN·m" or name == "pchip" or "/rad/s" in unit for unit in curve.units)


@pytest.mark.parametrize(
    ("name", "units", "words"),
    [
        ("inertia_physical", {"x_unit": "rad/s"}, "takes N·m over Hz, not"),
        ("inertia_physical", {"y_unit": "mN·m"}, "takes N·m over Hz, not"),
        ("expression", {"x_unit": "rpm"}, "takes values in SI units, not in rpm"),
        ("expression", {"y_unit": "mN·m"}, "takes values in SI units, not in mN·m"),
    ],
)
def test_fit_with_fixed_units_refuses_others(name, units, words):
    with pytest.raises(DataError, match=words):
        fit(name, replace(points(name), **units))


@pytest.mark.parametrize("name", sorted(set(FITS) - {"expression"}))
def test_fit_of_one_regressor_refuses_several(name):
    several = replace(points(name), x=np.column_stack([X, X]), regressors=("f", "temperature"))
    with pytest.raises(DataError, match="of one regressor is given 2: f, temperature"):
        fit(name, several)


@pytest.mark.parametrize("name", WITH_INTERCEPT)
def test_an_offset_moves_the_curve(name):
    data = noisy(name)
    value, u = fit(name, data).predict(BETWEEN)
    moved_value, moved_u = fit(name, Points(X, data.y + 0.5, data.u_y)).predict(BETWEEN)
    assert moved_value == pytest.approx(value + 0.5, rel=1e-7)
    assert moved_u == pytest.approx(u, rel=1e-5)


@pytest.mark.parametrize("x", [0.9, 36.0, -1.0, 1e6, np.nan])
def test_fit_never_extrapolates(name, x):
    curve = fit(name, noisy(name))
    assert curve.valid_x == (1.0, 35.0)
    with pytest.raises(DataError, match=re.escape(f"from 1 to 35, not at {x:.6g}")):
        curve.predict(np.array([10.0, x]))


@pytest.mark.parametrize("n", [0, 1, 2])
def test_too_few_points_are_refused_with_their_number(name, n):
    data = points(name)
    with pytest.raises(DataError, match=rf"got {n}|{n} points cannot"):
        fit(name, Points(data.x[:n], data.y[:n], data.u_y[:n]))


@pytest.mark.parametrize("name", WEIGHABLE)
def test_point_with_huge_uncertainty_hardly_counts(name):
    data = points(name)
    y, u_y = data.y.copy(), data.u_y.copy()
    y[5], u_y[5] = y[5] + 0.3, 1e4
    curve = fit(name, Points(X, y, u_y), weighted=True)
    assert curve.predict(BETWEEN)[0] == pytest.approx(EXAMPLES[name].truth(BETWEEN), rel=1e-6)
    assert curve.residuals[5] == pytest.approx(0.3, abs=1e-5)


@pytest.mark.parametrize("name", WEIGHABLE)
def test_weighted_r_squared_uses_the_weighted_mean(name):
    u_nm = np.linspace(0.02, 0.005, len(X))
    data = replace(noisy(name), u_y=u_nm)
    curve = fit(name, data, weighted=True)
    weights = u_nm**-2 / np.mean(u_nm**-2)
    rss = np.sum(weights * curve.residuals**2)
    centre = np.average(data.y, weights=weights) if curve.names[0] in {"c0", "T0"} else 0.0
    total = np.sum(weights * (data.y - centre) ** 2)
    assert curve.r_squared == pytest.approx(1 - rss / total, abs=1e-12)
    assert curve.residual_s == pytest.approx(np.sqrt(rss / curve.dof), rel=1e-6)


@pytest.mark.parametrize(
    ("name", "settings"),
    [("pchip", {}), *((name, {"weighted": True}) for name in WEIGHABLE)],
)
@pytest.mark.parametrize("u_y", [None, np.full(12, np.nan), np.full(12, np.inf)])
def test_fit_that_needs_uncertainties_refuses_without(name, settings, u_y):
    with pytest.raises(DataError, match="needs the uncertainty of every point"):
        fit(name, replace(points(name), u_y=u_y), **settings)


def test_only_aicc_has_candidates(name):
    assert isinstance(fit(name, points(name)), Chosen) == (name == "aicc")


def test_every_fit_is_documented_with_its_settings():
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    documented = {name: set(re.findall(r"`(\w+)`", what)) for name, what in rows}
    assert documented == {
        name: set(REGISTRY.settings_of("fit", name).model_fields) for name in FITS
    }


def test_scores_on_the_page_are_those_of_table_2():
    torque = np.array([0.83, 1.21, 1.64, 2.32, 3.01, 3.96, 5.12, 6.91])
    table_2 = Points(np.array([1.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0]), torque)
    documented = re.findall(r"^\| \{1, .*\| (-\d+\.\d) \|", PAGE.read_text("utf-8"), re.MULTILINE)
    curve = REGISTRY.make("fit", "aicc", {})(table_2)
    assert [f"{candidate.score:.1f}" for candidate in curve.candidates] == documented
