from __future__ import annotations

from math import hypot, inf, isinf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.uncertainty import Corrected, Distribution, Effect, Input, MeasurementModel
from rigrunner.signal.propagation import propagate, sensitivities


def linear(*terms, correlation=None):
    """Return y = sum of c x for terms (c, Input)."""
    equation = lambda x: sum(c * x[each.name] for c, each in terms)  # noqa: E731  (an equation)
    return MeasurementModel(tuple(each for _, each in terms), equation, correlation)


def by_name(components):
    return {part.name: part for part in components}


def test_independent_inputs_add_in_squares():
    propagated = propagate(linear((2.0, Input("a", 1.0, 0.3, 9)), (-1.0, Input("b", 5.0, 0.8, 4))))
    assert propagated.estimate.value == pytest.approx(-3.0)
    assert propagated.estimate.u == pytest.approx(1.0)
    assert propagated.estimate.dof == pytest.approx(1 / (0.6**4 / 9 + 0.8**4 / 4))


def test_a_model_is_propagated_once():
    """A method does it, and what it gives is held against its model."""
    model = linear((2.0, Input("a", 1.0, 0.3, 9)))
    assert propagate(model) is propagate(model)
    assert propagate(linear((2.0, Input("a", 1.0, 0.6, 9)))).estimate.u == pytest.approx(1.2)


def test_a_line_tells_estimate_sensitivity_and_contribution():
    gain = Input("gain", 0.5, 0.01, inf, Distribution.RECTANGULAR, "V", common=True)
    part = by_name(propagate(linear((-3.0, gain))).components)["gain"]
    assert (part.value, part.unit, part.input_u) == (0.5, "V", 0.01)
    assert part.sensitivity == pytest.approx(-3.0)
    assert part.u == pytest.approx(0.03)
    assert (part.distribution, part.common, part.dof) == ("rectangular", True, inf)


def test_gum_h2_resistance():
    """JCGM 100:2008, Table H.4: R = 127.732(71), X = 219.847(295), Z = 254.260(236) ohm."""
    inputs = (
        Input("V", 4.9990, 0.0032, 4, unit="V", ensemble="readings"),
        Input("I", 19.6610e-3, 0.0095e-3, 4, unit="A", ensemble="readings"),
        Input("phi", 1.04446, 0.00075, 4, unit="rad", ensemble="readings"),
    )
    r = np.array([[1, -0.36, 0.86], [-0.36, 1, -0.65], [0.86, -0.65, 1]])

    def estimate_of(equation):
        return propagate(MeasurementModel(inputs, equation, r)).estimate

    resistance = estimate_of(lambda x: x["V"] / x["I"] * np.cos(x["phi"]))
    reactance = estimate_of(lambda x: x["V"] / x["I"] * np.sin(x["phi"]))
    impedance = estimate_of(lambda x: x["V"] / x["I"])
    assert (resistance.value, resistance.u) == pytest.approx((127.732, 0.071), abs=1.2e-3)
    assert (reactance.value, reactance.u) == pytest.approx((219.847, 0.295), abs=1.2e-3)
    assert (impedance.value, impedance.u) == pytest.approx((254.260, 0.236), abs=1.2e-3)
    assert resistance.dof == pytest.approx(4)


def test_one_estimation_shares_its_degrees_of_freedom():
    a, b = (Input(name, 0.0, 1.0, 5, ensemble="fit") for name in "ab")
    apart = (Input("a", 0.0, 1.0, 5), Input("b", 0.0, 1.0, 5))
    assert propagate(linear((1, a), (1, b))).estimate.dof == pytest.approx(5)
    assert propagate(linear(*((1, x) for x in apart))).estimate.dof == pytest.approx(10)


def test_inputs_of_one_line_are_one_line_with_their_covariance():
    a, b = (Input(name, 3.0, 1.0, 5, line="fit", ensemble="fit") for name in "ab")
    r = np.array([[1.0, -0.9], [-0.9, 1.0]])
    model = linear((1, a), (1, b), correlation=r)
    (part,) = propagate(model).components
    assert part.name == "fit"
    assert part.u == pytest.approx(sqrt(2 - 1.8))
    assert part.sensitivity == 1.0
    assert np.isnan(part.value)


def test_correlation_without_common_degrees_of_freedom_is_refused():
    r = np.array([[1.0, 0.5], [0.5, 1.0]])
    model = linear((1, Input("a", 0, 1, 5)), (1, Input("b", 0, 1, 7)), correlation=r)
    with pytest.raises(ValueError, match="a and b are correlated"):
        propagate(model)


def test_known_limits_may_be_correlated():
    r = np.array([[1.0, 1.0], [1.0, 1.0]])
    inputs = (Input("loaded", 0, 2.0), Input("no load", 0, 2.0))
    opposite = linear((1, inputs[0]), (-1, inputs[1]), correlation=r)
    assert propagate(opposite).estimate.u == pytest.approx(0, abs=1e-12)
    assert isinf(propagate(opposite).estimate.dof)


def test_of_what_is_certain_nothing_is_uncertain():
    estimate = propagate(linear((2.0, Input("a", 1.0, 0.0, 3)))).estimate
    assert (estimate.value, estimate.u, estimate.dof) == (2.0, 0.0, inf)
    assert propagate(MeasurementModel((), Corrected(0.7, ()))).estimate.value == 0.7


def test_corrected_value_with_scales():
    fn = Input("fn", 400.0, 5.0, 20, unit="Hz")
    gain = Input("gain", 0.0, 0.002, unit="1")
    model = MeasurementModel((fn, gain), Corrected(0.7, (Effect(fn, 0.001),), scales=("gain",)))
    propagated = propagate(model)
    assert propagated.estimate.value == 0.7
    assert sensitivities(model) == pytest.approx([0.001, -0.7], rel=1e-5)
    assert propagated.estimate.u == pytest.approx(hypot(0.005, 0.0014), rel=1e-5)


@given(
    st.lists(
        st.tuples(st.floats(-10, 10), st.floats(0, 10), st.floats(1, 1e3)), min_size=1, max_size=6
    )
)
def test_welch_satterthwaite(parts):
    """GUM G.4.1 written out."""
    inputs = [(c, Input(str(i), 0.0, u, dof)) for i, (c, u, dof) in enumerate(parts)]
    estimate = propagate(linear(*inputs)).estimate
    u = [abs(c) * x.u for c, x in inputs]
    total = sqrt(sum(part**2 for part in u))
    assert estimate.u == pytest.approx(total, abs=1e-12)
    if total > 1e-6:
        spread = sum((part / total) ** 4 / x.dof for part, (_, x) in zip(u, inputs, strict=True))
        assert estimate.dof == pytest.approx(1 / spread, rel=1e-6)


def test_an_input_that_comes_twice_is_refused():
    with pytest.raises(ValueError, match="is repeated in a, a"):
        linear((1, Input("a", 0, 1)), (1, Input("a", 0, 1)))


def test_a_correlation_of_another_shape_is_refused():
    with pytest.raises(ValueError, match="1 inputs"):
        linear((1, Input("a", 0, 1)), correlation=np.eye(2))
