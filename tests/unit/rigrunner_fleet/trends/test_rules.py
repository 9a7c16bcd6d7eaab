"""The first value at which each rule signals, and the false alarms of each set of rules."""

from __future__ import annotations

import numpy as np
import pytest

from rigrunner_fleet.trends.rules import signals

UP_AND_DOWN = [0.5 * (-1) ** i for i in range(14)]


@pytest.mark.parametrize(
    ("values", "rules", "name", "index"),
    [
        ([0.0, 3.1], "nelson", "Nelson 1", 1),
        ([0.4] * 9, "nelson", "Nelson 2", 8),
        ([-0.3, -0.2, -0.1, 0.1, 0.2, 0.3], "nelson", "Nelson 3", 5),
        (UP_AND_DOWN, "nelson", "Nelson 4", 13),
        ([2.1, 0.5, 2.2], "nelson", "Nelson 5", 2),
        ([1.1, 1.2, -0.5, 1.3, 1.4], "nelson", "Nelson 6", 4),
        ([0.5, -0.4, -0.3] * 5, "nelson", "Nelson 7", 14),
        ([1.5, -1.5, -1.2, 1.1, 1.4, -1.3, 1.2, -1.1], "nelson", "Nelson 8", 7),
        ([-3.1], "western-electric", "Western Electric 1", 0),
        ([-2.1], "western-electric", "", -1),
        # two of the first three, whatever the third value
        ([-2.1, -2.2, 0.5], "western-electric", "Western Electric 2", 1),
        ([1.1, 1.2, 1.3, 1.4, -0.5], "nelson", "Nelson 6", 3),
        ([0.0, -2.1, -2.2], "western-electric", "Western Electric 2", 2),
        ([0.0, -1.1, -1.2, -1.1, -1.2], "western-electric", "Western Electric 3", 4),
        ([0.4] * 8, "western-electric", "Western Electric 4", 7),
    ],
)
def test_rule_signals_at_its_first_value(values, rules, name, index):
    met = signals([10.0 + 2.0 * value for value in values], 10.0, 2.0, rules)
    assert [(signal.rule.name, signal.index) for signal in met] == ([(name, index)] if name else [])


@pytest.mark.parametrize(
    ("numbers", "published"),
    [
        ((1,), 370.40),
        ((1, 2), 225.44),
        ((1, 3), 166.05),
        ((1, 4), 152.73),
        ((1, 2, 3), 132.89),
        ((1, 2, 3, 4), 91.75),
    ],
)
def test_average_run_lengths_equal_published_ones(numbers, published):
    """Champ and Woodall, Technometrics 29 (1987) 393-399, table 1: ARL of rules without a shift."""
    names = {f"Western Electric {number}" for number in numbers}
    rng = np.random.default_rng(5)
    lengths = []
    for _ in range(600):
        values, alarms = rng.normal(size=4000), []
        for count in (400, 4000):  # most signal early
            alarms = [
                signal
                for signal in signals(values[:count], 0.0, 1.0, "western-electric")
                if signal.rule.name in names
            ]
            if alarms:
                break
        lengths.append(alarms[0].index + 1 if alarms else 4000)
    assert np.mean(lengths) == pytest.approx(published, rel=0.1)


def test_shewhart_rule_is_the_limits_only():
    values = np.random.default_rng(6).normal(size=3000)
    indices = [signal.index for signal in signals(values, 0.0, 1.0, "shewhart")]
    assert indices == list(np.flatnonzero(np.abs(values) > 3.0))
