"""What stated errors of a transducer come to, by hand from their definitions."""

from __future__ import annotations

from math import sqrt

import pytest
from pydantic import ValidationError

from rigrunner.api.instruments import Instrument
from rigrunner.signal.inputs import model_of
from rigrunner.signal.propagation import propagate
from rigrunner.signal.transducer import transducer_effects

TORQUE = {
    "channel": "tester.torque",
    "serial": "4711",
    "full_scale": "10 N·m",
    "accuracy": "0.1 % FS",
}
SOURCE = "certificate 12345 DK-17"


def instrument(**errors):
    stated = {name: {"source": SOURCE} | each for name, each in errors.items()}
    return Instrument.model_validate(TORQUE | {"accuracy": {"overall": "0.1 % FS"} | stated})


def contributions(result, readings, slow, **errors):
    """Return what each line contributes to the standard uncertainty, by its name."""
    effects = transducer_effects(instrument(**errors), result, readings, slow=slow)
    return {line.name: line.u for line in propagate(model_of(result, effects)).components}


def test_what_does_not_grow_with_the_reading_is_in_the_unit_of_the_instrument():
    accuracy = {"overall": "0.1 % FS", "hysteresis": {"limit": "3 N", "source": SOURCE}}
    force = TORQUE | {"measures": "force", "full_scale": "10 kN", "accuracy": accuracy}
    (effect,) = transducer_effects(Instrument.model_validate(force), 1.0, (1.0,), slow=1.0)

    assert (effect.input.unit, effect.input.u) == ("N", pytest.approx(3 / sqrt(3)))


def test_nothing_is_added_where_nothing_is_stated():
    plain = Instrument.model_validate(TORQUE)
    assert transducer_effects(plain, 1.0, (7.0, 6.0), slow=1.0) == ()
    assert transducer_effects(instrument(), 1.0, (7.0, 6.0), slow=1.0) == ()


@pytest.mark.parametrize(
    ("name", "errors", "expected"),
    [
        # readings of 4 and 3 N·m: 5 N·m together; rectangular, half-width over the square root of 3
        ("repeatability", {"repeatability": {"limit": "0.02 % reading"}}, 2e-4 * 5 / sqrt(3)),
        ("repeatability", {"repeatability": {"limit": "0.02 % FS"}}, 2e-3 * sqrt(2) / sqrt(3)),
        ("hysteresis", {"hysteresis": {"limit": "3 mN·m"}}, 3e-3 * sqrt(2) / sqrt(3)),
        # a step of 2 mN·m: within half of it
        ("resolution", {"resolution": {"limit": "2 mN·m"}}, 1e-3 * sqrt(2) / sqrt(3)),
        # 0.02 % of the larger reading, of which a tenth reaches the result
        ("creep", {"creep": {"limit": "0.02 % reading"}}, 2e-4 * 4 * 0.1 / sqrt(3)),
        # 0.05 % of 10 N·m per 10 K, 4 K away
        (
            "temperature effect on zero",
            {"temperature_zero": {"limit": "0.05 % FS", "per": "10 K", "within": "4 K"}},
            5e-3 * 0.4 * 0.1 / sqrt(3),
        ),
        # of the result of 1 N·m, as the gain
        (
            "temperature effect on sensitivity",
            {"temperature_sensitivity": {"limit": "0.1 % reading", "per": "10 K", "within": "5 K"}},
            5e-4 / sqrt(3),
        ),
    ],
)
def test_each_error_is_a_line_with_its_source(name, errors, expected):
    lines = contributions(1.0, (4.0, 3.0), 0.1, **errors)
    assert lines == {f"transducer {name} ({SOURCE})": pytest.approx(expected, rel=1e-12)}


@pytest.mark.parametrize(
    ("distribution", "divisor"),
    [("rectangular", sqrt(3)), ("triangular", sqrt(6)), ("arcsine", sqrt(2)), ("normal", 2.0)],
)
def test_the_distribution_is_the_stated_one(distribution, divisor):
    stated = {"limit": "0.01 N·m", "distribution": distribution}
    (effect,) = transducer_effects(instrument(hysteresis=stated), 1.0, (1.0,), slow=1.0)
    assert effect.input.u == pytest.approx(0.01 / divisor, rel=1e-12)
    assert effect.input.distribution == distribution
    assert effect.input.common


def test_errors_are_independent_of_each_other():
    both = {"hysteresis": {"limit": "3 mN·m"}, "repeatability": {"limit": "4 mN·m"}}
    effects = transducer_effects(instrument(**both), 1.0, (1.0,), slow=1.0)
    assert propagate(model_of(1.0, effects)).estimate.u == pytest.approx(5e-3 / sqrt(3), rel=1e-12)


@pytest.mark.parametrize(
    ("errors", "message"),
    [
        ({"hysteresis": {"limit": "0.2 K"}}, "got '0.2 K', a temperature, expected a torque"),
        ({"hysteresis": {"limit": "0.02"}}, "has no unit"),
        ({"hysteresis": {"limit": "-1 mN·m"}}, "got '-1 mN·m', expected 0 or more"),
        ({"creep": {"limit": "1 % FS", "distribution": "flat"}}, "'rectangular'"),
        ({"temperature_zero": {"limit": "1 % FS", "per": "10 K"}}, "within"),
        (
            {"temperature_zero": {"limit": "1 % FS", "per": "10 °C", "within": "1 K"}},
            "is a temperature, not a difference",
        ),
        ({"linearity": {"limit": "1 % FS"}}, "linearity"),
    ],
)
def test_entries_that_say_nothing_are_refused(errors, message):
    with pytest.raises(ValidationError, match=message):
        instrument(**errors)
