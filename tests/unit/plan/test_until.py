"""A repetition that ends by a result: a value that is not finite is refused."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan

import pytest

from rigrunner.api.errors import DataError
from rigrunner.api.quantity import Estimate
from rigrunner.plan.conditions import ResultReached


@dataclass
class FakeDoing:
    value: float
    notes: tuple[str, ...] = ()

    def result(self, _: str) -> Estimate:
        return Estimate(self.value, 0.1, unit="°C")

    def note(self, _: str, text: str) -> None:
        self.notes += (text,)


REACHED = ResultReached("warmest", -inf, 333.15, "above 60 °C", "°C", number=2, of=5)


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_nonfinite_result_does_not_end_a_repetition(value):
    with pytest.raises(DataError, match="'warmest' is not a finite number"):
        REACHED.do("main[0]", FakeDoing(value))


@pytest.mark.parametrize(("celsius", "ends"), [(59.99, False), (60.0, False), (60.01, True)])
def test_a_result_is_compared_in_its_own_unit(celsius, ends):
    assert REACHED.do("main[0]", FakeDoing(celsius)).leaves is ends
