"""Checks on fits, with data of their own and with data from the fit's own curve."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import FitRecord
from rigrunner_testing.check import AnyCheck, Nonconformity, applies, check, demand

if TYPE_CHECKING:
    from rigrunner.api.analysis import Curve, Fit
    from rigrunner.api.data import Array
    from rigrunner_testing.subjects import Subject

X_HZ = np.array([1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 18.0, 20.0, 25.0, 30.0, 33.0, 35.0])
BETWEEN_HZ = np.array([2.0, 12.5, 19.0, 28.0, 34.0])
U_NM = 0.01
"""Standard uncertainty, and scatter, of each point."""
REPETITIONS = 300
SCATTER = 0.2
"""Five standard errors of a standard deviation of 300 normal values, 1/sqrt(2 * 299) each."""
SAME, U_SAME = 1e-6, 1e-4
"""Relative: by how much a curve, and its uncertainty, may differ by rounding and iteration."""
_OF_A_CURVE = (
    "formula",
    "names",
    "units",
    "coefficients",
    "covariance",
    "dof",
    "residuals",
    "residual_s",
    "r_squared",
    "valid_x",
    "predict",
)


def no_load_torque_nm(frequency_hz: Array) -> Array:
    """Return a torque like that of a rig without load: rising, curved, of one sign."""
    return np.asarray(0.9 + 0.025 * frequency_hz + 0.004 * frequency_hz**2)


@check(
    fix="fit without bias: least squares of the curve's own values gives its parameters",
    needs=("curve_is_whole",),
)
def recovers_its_own_curve(subject: Subject) -> None:
    """Data on a curve of the fit's own reproduce that curve."""
    fit = _fit(subject)
    first = fit(_points())
    values, _ = first.predict(X_HZ)
    refit = fit(replace(_points(), y=values))
    demand(
        np.allclose(refit.coefficients, first.coefficients, rtol=1e-5, atol=1e-9),
        f"coefficients {first.coefficients} come back as {refit.coefficients}",
    )
    _check_same_curve(first, refit, "data from its own curve give")


@check(fix="correct the formula, or the example that the record states", needs=("curve_is_whole",))
def published_examples_hold(subject: Subject) -> None:
    """The published examples in the record, such as certified data sets, are reproduced."""
    record = subject.record_as(FitRecord)
    applies(record.examples, "its record states no examples")
    for example in record.examples:
        fit: Fit = subject.registry.make(subject.kind, subject.name, example.settings)
        curve = fit(Points(np.array(example.x), np.array(example.y)))
        coefficients = np.array(example.coefficients)
        _check_close(example.source, "coefficients", curve.coefficients, coefficients)
        if example.u:
            u = np.sqrt(np.diag(curve.covariance))
            _check_close(example.source, "standard uncertainties", u, np.array(example.u))


def _check_close(source: str, what: str, actual: Array, stated: Array) -> None:
    is_same = actual.shape == stated.shape and np.allclose(actual, stated, rtol=1e-6, atol=0)
    demand(is_same, f"{source}: {what} are {actual}, stated are {stated}")


@check(fix="give one name, one unit and one row of the covariance for each coefficient")
def curve_is_whole(subject: Subject) -> None:
    """Names, units, coefficients and covariance are consistent; residuals are the curve's."""
    points = _noisy(1)
    curve = _fit(subject)(points)
    missing = [name for name in _OF_A_CURVE if not hasattr(curve, name)]
    demand(
        not missing,
        f"it gave a {type(curve).__name__}, which has no {', '.join(missing)}",
        fix="return a Curve, as rigrunner.api.analysis has it: is there a `return`?",
    )
    p = len(curve.coefficients)
    demand(p, "the curve has no coefficients")
    demand(len(set(curve.names)) == p, f"{p} coefficients have the names {', '.join(curve.names)}")
    demand(len(curve.units) == p, f"{p} coefficients have {len(curve.units)} units")
    demand(curve.formula.strip(), "the curve has no formula")
    covariance = curve.covariance
    demand(covariance.shape == (p, p), f"the covariance has the shape {covariance.shape}")
    demand(np.allclose(covariance, covariance.T, rtol=1e-9), "the covariance is not symmetric")
    variances = np.diag(covariance)
    demand((variances >= 0).all() and np.isfinite(variances).all(), f"variances are {variances}")
    demand(curve.dof > 0, f"the degrees of freedom are {curve.dof}")
    values, _ = curve.predict(points.x)
    is_same = np.allclose(curve.residuals, points.y - values, atol=1e-9)
    demand(is_same, "the residuals are not what was observed minus the curve")


@check(
    fix="derive the units of the coefficients from `points.x_unit` and `points.y_unit`",
    needs=("curve_is_whole",),
)
def units_are_kept(subject: Subject) -> None:
    """In other units the curve is the same, or the points are refused."""
    fit, points = _fit(subject), _noisy(2)
    assert points.u_y is not None  # noqa: S101  (`_noisy` gives it)
    values, u = fit(points).predict(BETWEEN_HZ)
    turns = 2 * np.pi
    other = Points(turns * X_HZ, 1e3 * points.y, 1e3 * points.u_y, x_unit="rad/s", y_unit="mN·m")
    try:
        curve = fit(other)
    except DataError:
        return
    other_values, other_u = curve.predict(turns * BETWEEN_HZ)
    is_same = np.allclose(other_values, 1e3 * values, rtol=SAME)
    is_same &= np.allclose(other_u, 1e3 * u, rtol=U_SAME)
    demand(is_same, "in mN·m over rad/s it is another")
    torque = [unit for unit in curve.units if "mN·m" in unit]
    demand(torque, f"fitted in mN·m, its coefficients are in {', '.join(curve.units)}")


@check(
    fix="state the covariance of the coefficients by the law of propagation (GUM 5.2)",
    needs=("curve_is_whole",),
)
def uncertainty_is_the_scatter(subject: Subject) -> None:
    """Over 300 noisy repetitions the curve scatters as it states, within 20 %."""
    fit = _fit(subject)
    clean, _ = fit(_points()).predict(X_HZ)
    rng = np.random.default_rng(8)
    noise = rng.normal(0, U_NM, (REPETITIONS, len(X_HZ)))
    curves = [fit(replace(_points(), y=clean + row)) for row in noise]
    predicted = np.array([curve.predict(BETWEEN_HZ) for curve in curves])
    scatter = predicted[:, 0].std(axis=0, ddof=1)
    stated = np.sqrt(np.mean(predicted[:, 1] ** 2, axis=0))
    _check_scatter("the curve", scatter, stated)
    if len({curve.formula for curve in curves}) > 1:
        return  # it chose another curve now and then: coefficients are not comparable
    scatter = np.array([curve.coefficients for curve in curves]).std(axis=0, ddof=1)
    stated = np.sqrt(np.mean([np.diag(curve.covariance) for curve in curves], axis=0))
    _check_scatter("its coefficients", scatter, stated)


def _check_scatter(what: str, scatter: Array, stated: Array) -> None:
    ratios = stated / scatter
    demand(
        (np.abs(ratios - 1) <= SCATTER).all(),
        f"{what} scatter by {scatter}, and the standard uncertainty stated is {stated}",
    )


@check(fix="let nothing depend on the order in which points come", needs=("curve_is_whole",))
def order_does_not_matter(subject: Subject) -> None:
    """The order of the points does not matter."""
    fit, points = _fit(subject), _noisy(3)
    assert points.u_y is not None  # noqa: S101  (`_noisy` gives it)
    order = np.random.default_rng(2).permutation(len(X_HZ))
    shuffled = Points(points.x[order], points.y[order], points.u_y[order])
    _check_same_curve(fit(points), fit(shuffled), "in another order the points give")


@check(fix="use no absolute tolerances or limits on y and u(y)", needs=("curve_is_whole",))
def scale_does_not_matter(subject: Subject) -> None:
    """Points three times as high give such a curve; a larger u(y) alone, the same curve."""
    fit, points = _fit(subject), _noisy(4)
    assert points.u_y is not None  # noqa: S101  (`_noisy` gives it)
    curve = fit(points)
    values, u = curve.predict(BETWEEN_HZ)
    scaled_values, scaled_u = fit(Points(X_HZ.copy(), 3 * points.y, 3 * points.u_y)).predict(
        BETWEEN_HZ
    )
    is_same = np.allclose(scaled_values, 3 * values, rtol=SAME)
    demand(is_same, f"three times as high it is {scaled_values}, not 3 times {values}")
    demand(
        np.allclose(scaled_u, 3 * u, rtol=U_SAME),
        f"three times as high its uncertainty is {scaled_u}, not 3 times {u}",
    )
    doubtful, _ = fit(replace(points, u_y=2 * points.u_y)).predict(BETWEEN_HZ)
    is_same = np.allclose(doubtful, values, rtol=SAME)
    demand(is_same, f"with twice the uncertainty of each point it is {doubtful}, not {values}")


@check(
    fix="state `valid_x`, and raise DataError from `predict` outside of it",
    needs=("curve_is_whole",),
)
def never_extrapolates(subject: Subject) -> None:
    """It states its range, within the points, and refuses any other x."""
    curve = _fit(subject)(_noisy(5))
    low, high = curve.valid_x
    inside = X_HZ[0] <= low < high <= X_HZ[-1]
    demand(inside, f"fitted from 1 Hz to 35 Hz, it may be used from {low:g} to {high:g}")
    for x in (0.9, 36.0, -1.0, 1e6, np.nan):
        try:
            curve.predict(np.array([10.0, x]))
        except DataError:
            continue
        raise Nonconformity(f"it gives a value at {x:g}, outside of {low:g} to {high:g}")


@check(
    fix="compare the number of points with that of coefficients, and raise DataError with both",
    needs=("curve_is_whole",),
)
def too_few_points_refused(subject: Subject) -> None:
    """Too few points are refused; any result is finite."""
    fit, points = _fit(subject), _noisy(6)
    assert points.u_y is not None  # noqa: S101  (`_noisy` gives it)
    p = len(fit(points).coefficients)
    if p == len(X_HZ):  # it interpolates: of fewer points it has fewer coefficients
        p = 1
    for n in range(len(X_HZ)):
        few_points = Points(points.x[:n], points.y[:n], points.u_y[:n])
        try:
            curve = fit(few_points)
        except DataError as error:
            demand(str(n) in str(error), f"of {n} points it says '{error}', not how many there are")
            continue
        demand(n >= p and n > 0, f"it fits {p} coefficients to {n} points")
        finite = np.isfinite(curve.coefficients).all() and np.isfinite(curve.covariance).all()
        demand(finite, f"of {n} points it gives coefficients or a covariance that are not finite")


@check(fix="raise DataError where x or y are not finite", needs=("curve_is_whole",))
def not_a_number_refused(subject: Subject) -> None:
    """A point that is not a finite number is refused."""
    fit = _fit(subject)
    for axis in ("x", "y"):
        for invalid in (np.nan, np.inf):
            values = getattr(_points(), axis).copy()
            values[3] = invalid
            try:
                fit(replace(_points(), **{axis: values}))
            except DataError:
                continue
            raise Nonconformity(f"it fits points of which one has {axis} = {invalid}")


@check(fix="copy what you change", needs=("curve_is_whole",))
def leaves_the_points_alone(subject: Subject) -> None:
    """It does not change the points."""
    points = _noisy(7)
    assert points.u_y is not None  # noqa: S101  (`_noisy` gives it)
    before = [array.copy() for array in (points.x, points.y, points.u_y)]
    _fit(subject)(points).predict(BETWEEN_HZ)
    after = (points.x, points.y, points.u_y)
    demand(all(map(np.array_equal, before, after)), "it changes the points that it is given")


def _fit(subject: Subject) -> Fit:
    fit: Fit = subject.make()
    return fit


def _points() -> Points:
    return Points(X_HZ.copy(), no_load_torque_nm(X_HZ), np.full(len(X_HZ), U_NM))


def _noisy(seed: int) -> Points:
    noise = np.random.default_rng(seed).normal(0, U_NM, len(X_HZ))
    return replace(_points(), y=no_load_torque_nm(X_HZ) + noise)


def _check_same_curve(first: Curve, second: Curve, what: str) -> None:
    first_values, _ = first.predict(BETWEEN_HZ)
    second_values, _ = second.predict(BETWEEN_HZ)
    is_same = np.allclose(second_values, first_values, rtol=SAME)
    demand(is_same, f"{what} {second_values} at {BETWEEN_HZ} Hz, not {first_values}")


CHECKS: tuple[AnyCheck, ...] = (
    curve_is_whole,
    recovers_its_own_curve,
    published_examples_hold,
    units_are_kept,
    uncertainty_is_the_scatter,
    order_does_not_matter,
    scale_does_not_matter,
    never_extrapolates,
    too_few_points_refused,
    not_a_number_refused,
    leaves_the_points_alone,
)
