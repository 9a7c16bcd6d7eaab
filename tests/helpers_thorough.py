"""Cases and examples of which fewer show what all show too: these run with `--all`, as CI does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from collections.abc import Sequence


def first(count: int, cases: Sequence[object]) -> list[object]:
    """Return the cases as parameters: all but the first ones are thorough."""
    thorough = (pytest.param(case, marks=pytest.mark.thorough) for case in cases[count:])
    return [*cases[:count], *thorough]


ALL_EXAMPLES, FEWER_EXAMPLES = "all examples", "fewer examples"
"""The profiles of hypothesis, with `--all` or for named files, and without."""


def examples(count: int) -> int:
    """Return how many examples hypothesis tries: a third of the count, but ten, without `--all`.

    Each run draws others. A fault that one of twenty examples shows is found by 20 of them in two
    runs of three, by 60 in 19 of 20.
    """
    if settings.get_current_profile_name() == ALL_EXAMPLES:
        return count
    return max(count // 3, min(count, 10))
