"""The reason of a verdict as version 0.1.0 wrote it, read as it is written now."""

import pytest

from rigrunner.proof.compare import mismatches, today

LIMIT = "the limit ≤ 0.95 N·m"


@pytest.mark.parametrize(
    ("then", "now"),
    [
        (
            f"0.7288 N·m is 0.2212 N·m within {LIMIT}, by at least U = 0.0102 N·m.",
            "Margin to the limit ≤ 0.95 N·m: 0.2212 N·m (U = 0.0102 N·m).",
        ),
        (
            (
                f"0.9000 N·m is 0.0500 N·m within {LIMIT}, but by less than U = 0.0980 N·m:"
                " conformity is not demonstrated."
            ),
            (
                "Margin to the limit ≤ 0.95 N·m: 0.0500 N·m, less than U = 0.0980 N·m;"
                " conformity is not demonstrated."
            ),
        ),
        (
            f"At 35 Hz: 1.2000 N·m is 0.2500 N·m outside {LIMIT}.",
            "At 35 Hz: outside the limit ≤ 0.95 N·m by 0.2500 N·m.",
        ),
        (
            f"0.9600 N·m is 0.0100 N·m outside {LIMIT}, but by no more than U = 0.0980 N·m.",
            "Outside the limit ≤ 0.95 N·m by 0.0100 N·m, no more than U = 0.0980 N·m.",
        ),
        (
            "Voltage: 12.3 V is 0.2 V outside the limit 11 V to 12.1 V, by more than U = 1 V.",
            "Voltage: Outside the limit 11 V to 12.1 V by 0.2 V, more than U = 1 V.",
        ),
        (
            (
                "0.4500 N·m is 0.0500 N·m within the limit 0.4 N·m to 0.5 N·m, but no value is"
                " within both limits by U = 0.1176 N·m: so uncertain a result cannot pass."
            ),
            (
                "Margin to the limit 0.4 N·m to 0.5 N·m: 0.0500 N·m; the limits are too close for"
                " U = 0.1176 N·m, so no result can pass."
            ),
        ),
        ("the customer's name was misspelt", "the customer's name was misspelt"),
    ],
)
def test_an_older_reason_is_read_as_todays(then, now):
    assert today(then) == now
    assert today(now) == now
    assert list(mismatches({"reason": then}, {"reason": now})) == []


def test_another_margin_is_a_difference():
    then = f"0.7288 N·m is 0.2312 N·m within {LIMIT}, by at least U = 0.0102 N·m."
    now = "Margin to the limit ≤ 0.95 N·m: 0.2212 N·m (U = 0.0102 N·m)."
    (mismatch,) = mismatches({"reason": then}, {"reason": now})
    assert mismatch.where == "reason"
