from __future__ import annotations

from math import isnan, nan

import pytest

from rigrunner.api.checks import ABOVE_ZERO, Limit, is_skipped, skipped

BAND = Limit(name="band", good="all good", advice="do", unit="Hz", lower=1.0, upper=3.0)


def band_check(*values):
    return BAND.check((value, f"is {value:g}") for value in values)


@pytest.mark.parametrize(
    ("value", "ok", "threshold"),
    [(1.0, True, 1.0), (3.0, True, 3.0), (0.9, False, 1.0), (3.1, False, 3.0), (1.9, True, 1.0)],
)
def test_limits_are_inclusive_and_the_nearer_one_is_the_threshold(value, ok, threshold):
    check = band_check(value)
    assert (check.ok, check.value, check.threshold, check.unit) == (ok, value, threshold, "Hz")


def test_check_has_the_worst_value_and_lists_all_failures():
    check = band_check(2.0, 3.5, 0.0, 2.5)
    assert check.text == "is 3.5; is 0"
    assert (check.value, check.threshold, check.advice) == (0.0, 1.0, "do")


def test_nan_fails_the_check():
    check = band_check(2.0, nan)
    assert not check.ok
    assert isnan(check.value)


def test_check_without_values_passes_without_a_value():
    check = band_check()
    assert (check.ok, check.text, check.advice) == (True, "all good", "")
    assert (check.value, check.threshold) == (None, None)


def test_prefix_is_put_before_the_name():
    assert BAND.check([], "no-load run: ").name == "no-load run: band"


def test_skipped_check_passes_and_is_marked():
    check = skipped("band", "nobody looked")
    assert (check.name, check.ok, check.text) == ("band", True, "not checked: nobody looked")
    assert is_skipped(check)
    assert not is_skipped(band_check(2.0))
    assert not is_skipped(band_check(0.0))


@pytest.mark.parametrize(
    ("limits", "unit", "words"),
    [
        ({"upper": 2.0}, "%", "at most 2 %"),
        ({"lower": 10.0}, "1", "at least 10"),
        ({"lower": 0.01, "upper": 0.3}, "1", "0.01 to 0.3"),
        ({"lower": ABOVE_ZERO}, "N·m", "above 0 N·m"),
    ],
)
def test_allowed_range_in_words(limits, unit, words):
    assert Limit(name="x", good="", advice="", unit=unit, **limits).allowed == words


@pytest.mark.parametrize(("value", "ok"), [(0.0, False), (-1.0, False), (1e-12, True)])
def test_above_zero_excludes_zero(value, ok):
    limit = Limit(name="x", good="", advice="", unit="N·m", lower=ABOVE_ZERO)
    assert limit.check([(value, "bad")]).ok is ok
