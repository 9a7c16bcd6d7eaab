"""What is quickly seen to be within its limits is what the judgement says nothing of."""

from __future__ import annotations

from math import inf, nextafter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import DataError
from rigrunner.api.quantity import parse_quantity
from rigrunner.engine.limits import clear_ranges, judge
from rigrunner.plan.actions import Limit

NAME = "press.torque"
bounds = st.floats(-1e3, 1e3).map(lambda number: f"{number:.6f} N·m")
near = st.sampled_from([-inf, inf])


def says_nothing(limit, value):
    try:
        return not judge([limit], {NAME: value})
    except DataError:
        return False


@given(bounds | st.none(), bounds | st.none(), st.floats(0, 10), st.floats(-2e3, 2e3), near)
def test_nothing_that_is_to_be_said_is_passed_over(low, high, marginal, value, towards):
    limit = Limit(
        NAME, parse_quantity(low) if low else None, parse_quantity(high) if high else None, marginal
    )
    ((name, least, greatest),) = clear_ranges([limit])
    assert name == NAME
    for one in (value, least, greatest, nextafter(least, towards), nextafter(greatest, towards)):
        if least <= one <= greatest and abs(one) != inf:
            assert says_nothing(limit, one)


@pytest.mark.parametrize("value", [1.0, 3.0])
def test_without_a_margin_the_limits_themselves_are_clear(value):
    limit = Limit(NAME, parse_quantity("1 N·m"), parse_quantity("3 N·m"))
    ((_, least, greatest),) = clear_ranges([limit])
    assert least <= value <= greatest
    assert says_nothing(limit, value)
