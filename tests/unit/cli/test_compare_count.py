from __future__ import annotations

import pytest

from rigrunner.cli.commands.compare import _count
from rigrunner.tools.comparing.compare import Comparison
from rigrunner.tools.comparing.tree import Change


@pytest.mark.parametrize(
    ("relevant", "words"),
    [
        ((True,), "1 difference"),
        ((True, True), "2 differences"),
        ((True, False), "1 difference, and 1 that does not matter"),
        ((True, True, False, False), "2 differences, and 2 that do not matter"),
    ],
)
def test_each_difference_is_counted_by_whether_it_matters(relevant, words):
    changes = tuple(Change("inputs", "text", matters=is_relevant) for is_relevant in relevant)
    assert _count(Comparison("a", "b", changes, "")) == words
