"""The results of analysis plugins are checked before use."""

from __future__ import annotations

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.analysis import Rejection
from rigrunner.api.data import Points
from rigrunner.api.errors import PluginError
from rigrunner.procedure import Measurand
from rigrunner.registry import Registry
from rigrunner.registry.lookup import Plugin, Provider
from rigrunner_bearings.api.compensations import CompensatedPoint
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.study.tools import analysis_ref
from rigrunner_bearings.torque.settings import SwingTorque
from unit.analysis.helpers_analysis import (
    LOADED_SPEC,
    PAPER_PEAK,
    acceptance,
    analysed,
    recording,
    registry,
    run_of,
)

HERTZ = (5, 10, 15, 20)
NAN = float("nan")


def _runs():
    scatter = 0.01 * np.random.default_rng(1).standard_normal((8, 12))
    loaded = [recording(0.5 + 1e-3 * f**2 + scatter[i], f) for i, f in enumerate(HERTZ)]
    no_load = [
        recording(0.1 + 1e-3 * f**2 + scatter[4 + i], f, load_n=0.0) for i, f in enumerate(HERTZ)
    ]
    return run_of(*loaded), run_of(*no_load)


def _registry_with(kind, plugin):
    """Return the shipped plugins and one called 'strange'."""
    shipped = {"compensation": "paper_peak", "fit": "polynomial", "outlier_rule": "grubbs"}
    record = registry().find(kind, shipped[kind]).record
    strange = replace(record, name="strange", factory=lambda _: plugin)
    return Registry((*registry().plugins, Plugin(kind, strange, Provider("test", ""))))


def _analysed(kind, plugin):
    changes = {
        "outlier_rule": {"outliers": "strange"},
        "fit": {"fits": ["strange"]},
        "compensation": {"compensations": ["strange", PAPER_PEAK], "primary": "strange"},
    }[kind]
    run, no_load = _runs()
    return analyse(
        replace(run, partners={"no_load": no_load}),
        (analysis_ref(SwingTorque.model_validate(LOADED_SPEC | changes)),),
        acceptance=acceptance(),
        measurand=Measurand(symbol="Td", name="torque"),
        lookup=_registry_with(kind, plugin),
    )


def _rejecting(index, value=1.0):
    return lambda _: [Rejection(index, value, "strange", 9.0, 1.0)]


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        (_rejecting(-1), "the index -1 of 12 values"),  # the last one as a Python index
        (_rejecting(12), "the index 12 of 12 values"),
        (_rejecting(index=True), "the index True"),
        (_rejecting(1.0), "the index 1.0"),
        (_rejecting(1, 1j), "a rejection of"),
        (lambda _: None, "None, expected a list"),
        (lambda _: [1], "1, expected a Rejection"),
        (lambda _: 2 * _rejecting(1)(_), "one rejection twice"),
    ],
)
def test_invalid_rejection_of_an_outlier_rule_is_refused(rule, message):
    with pytest.raises(PluginError, match="the outlier rule 'strange' gave") as caught:
        _analysed("outlier_rule", rule)
    assert message in caught.value.message


def test_numpy_integers_are_valid_rejection_indices():
    result = _analysed("outlier_rule", _rejecting(np.int64(3), np.float64(0.5)))
    rejections = TorqueDetails.of(result).loaded[0].peak_rejections
    assert [type(rejection.index) for rejection in rejections] == [int]
    assert [bool(kept) for kept in TorqueDetails.of(result).loaded[0].peak_kept] == [
        i != 3 for i in range(12)
    ]


def _in_place(values):
    values -= values.mean()
    return []


def test_outlier_rule_cannot_change_values_in_place():
    with pytest.raises(ValueError, match="read-only") as caught:
        _analysed("outlier_rule", _in_place)
    assert caught.value.__notes__ == ["in the outlier rule 'strange'"]


def _shipped():
    return registry().make("compensation", "paper_peak", {"coefficients": "refit"})


def _with_torque(**changes):
    def method(sweep):
        compensation = _shipped()(sweep)
        points = [replace(p, torque=replace(p.torque, **changes)) for p in compensation.points]
        return replace(compensation, points=tuple(points))

    return method


def _with_points(change):
    def method(sweep):
        compensation = _shipped()(sweep)
        return replace(compensation, points=change(compensation.points))

    return method


@pytest.mark.parametrize(
    ("method", "message"),
    [
        (_with_torque(value=NAN), "torque, raw, rig and frequency (nan"),
        (_with_torque(value=np.complex128(0.4 + 1j)), "torque, raw, rig and frequency"),
        (_with_torque(value="0.4"), "torque, raw, rig and frequency ('0.4'"),
        (_with_torque(value=np.array([0.4])), "torque, raw, rig and frequency (array"),
        (_with_torque(value=400.0), "whose value is 400, by its own model 0."),
        (_with_torque(unit="mN·m"), "a torque in 'mN·m' at 5 Hz, expected N·m"),
        (_with_torque(u=0.0), "whose u is 0, by its own model"),
        (_with_torque(u=NAN), "whose u is nan, by its own model"),
        (_with_torque(u=-1.0), "the uncertainty -1.0 at 5 Hz"),
        (_with_torque(dof=-3.0), "-3.0 degrees of freedom"),
        (_with_torque(dof=NAN), "whose dof is nan"),
        (_with_points(lambda points: points[1:]), "points at 10, 15, 20 Hz; expected one for each"),
        (_with_points(lambda points: points[::-1]), "points at 20, 15, 10, 5 Hz"),
        (_with_points(lambda points: points + points), "5, 10, 15, 20, 5, 10, 15, 20 Hz"),
        (_with_points(lambda _: ()), "points at no frequency"),
        (_with_points(lambda _: (0.4,) * 4), "0.4, expected a CompensatedPoint"),
        (lambda sweep: replace(_shipped()(sweep), not_applicable="no"), "points, and says that"),
        (lambda _: None, "None, expected a Compensation"),
    ],
)
def test_invalid_points_of_a_compensation_are_refused(method, message):
    with pytest.raises(PluginError, match="the compensation 'strange' gave") as caught:
        _analysed("compensation", method)
    assert message in caught.value.message
    assert "rigrunner check-plugin strange" in caught.value.hint


def test_compensation_cannot_change_the_sweep_in_place():
    def method(sweep):
        compensation = _shipped()(sweep)
        sweep.loaded[0].peak_nm[:] = 0.0
        return compensation

    with pytest.raises(ValueError, match="read-only") as caught:
        _analysed("compensation", method)
    assert caught.value.__notes__ == ["in the compensation 'strange'"]


def test_valid_points_are_not_converted_to_text():
    """The text of a point's waveforms would take a tenth of the time of a report."""

    class Silent(CompensatedPoint):
        def __repr__(self):
            raise AssertionError("no text is needed")

    def method(sweep):
        compensation = _shipped()(sweep)
        silent = [
            Silent(**{field.name: getattr(point, field.name) for field in fields(point)})
            for point in compensation.points
        ]
        return replace(compensation, points=tuple(silent))

    assert TorqueDetails.of(_analysed("compensation", method)).compensations["strange"].points


def test_not_applicable_method_does_not_affect_others():
    def method(sweep):
        return replace(_shipped()(sweep), points=(), not_applicable="not today")

    result = _analysed("compensation", method)
    assert not TorqueDetails.of(result).compensations["strange"].points
    assert len(TorqueDetails.of(result).compensations["paper_peak"].points) == len(HERTZ)


def _curve(**changes):
    def fit(points):
        curve = registry().make("fit", "polynomial", {"degree": 2})(points)
        names = "formula names units coefficients covariance dof residuals residual_s r_squared"
        attributes = {name: getattr(curve, name) for name in [*names.split(), "valid_x", "predict"]}
        return SimpleNamespace(**(attributes | changes))

    return fit


def _wrong_prediction(change):
    def fit(points):
        curve = _curve()(points)
        predict = curve.predict
        curve.predict = lambda x: change(*predict(x))
        return curve

    return fit


@pytest.mark.parametrize(
    ("fit", "message"),
    [
        (lambda _: None, "None, which is not a curve"),
        (_curve(coefficients=np.full(3, NAN)), "the coefficients array([nan, nan, nan])"),
        (_curve(coefficients=np.ones(3) + 1j), "the coefficients"),
        (_curve(coefficients=np.array(["1", "2", "3"])), "the coefficients"),
        (_curve(covariance=np.eye(2)), "the covariance"),
        (_curve(covariance=-np.eye(3)), "the negative variances"),
        (_curve(names=("a",)), "(1, 3) names and units of 3 coefficients"),
        (_curve(residuals=np.zeros(3)), "residuals that are not one a point"),
        (_curve(valid_x=(0.0,)), "which is not a curve"),
        (_curve(valid_x=(20.0, 5.0)), "the validity range 20.0 to 5.0"),
        (_wrong_prediction(lambda y, u: (y * NAN, u)), "the prediction"),
        (_wrong_prediction(lambda y, u: (y + 1j, u)), "the prediction"),
        (_wrong_prediction(lambda y, u: (y[:1], u[:1])), "the prediction"),
        (_wrong_prediction(lambda y, u: (y, -u)), "the uncertainty"),
        (_wrong_prediction(lambda y, u: (y, u * NAN)), "the uncertainty"),
        (_wrong_prediction(lambda y, _: y), "which is not a curve"),
    ],
)
def test_invalid_curve_of_a_fit_is_refused(fit, message):
    with pytest.raises(PluginError, match="the fit 'strange' gave") as caught:
        _analysed("fit", fit)
    assert message in caught.value.message


def test_fit_cannot_change_points_in_place():
    def fit(points):
        points.y[:] = 0.0

    x = np.arange(5.0)
    with pytest.raises(ValueError, match="read-only"):
        Scrutiny(_registry_with("fit", fit)).make("fit", "strange", {})(Points(x, x + 1))


def test_valid_compensation_is_unchanged():
    plain = analysed(*_runs(), accept=acceptance())
    checked = _analysed("compensation", _shipped())
    assert checked.headline == plain.headline
    assert checked.decision.verdict is plain.decision.verdict
