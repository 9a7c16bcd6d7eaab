"""What must hold of the outlier rule old_outlier_rule."""

from collections.abc import Callable

import numpy as np
import pytest

import rigrunner_old_outlier_rule as plugin


@pytest.mark.conformance("outlier_rule", "old_outlier_rule")
def test_it_keeps_to_what_every_outlier_rule_keeps_to(conformance: Callable[[], None]) -> None:
    """One test for each check of the conformance kit; what does not apply is skipped."""
    conformance()


def test_it_gives_the_known_answer() -> None:
    """Of 1, 2, 3, 4 and 9 the median is 3, and the median deviation 1: 9 is 6/1.4826 away."""
    rule = plugin.OldOutlierRule(plugin.OldOutlierRuleSettings())
    (found,) = rule(np.array([1.0, 2.0, 3.0, 4.0, 9.0]))
    assert (found.index, found.value) == (4, 9.0)
    assert found.statistic == pytest.approx(4.0469, abs=1e-4)
