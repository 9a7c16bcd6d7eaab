"""Cases of which the first show what the others show too: these run with `--all`, as CI does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Sequence


def first(count: int, cases: Sequence[object]) -> list[object]:
    """Return the cases as parameters: all but the first ones are thorough."""
    rest = (pytest.param(each, marks=pytest.mark.thorough) for each in cases[count:])
    return [*cases[:count], *rest]
