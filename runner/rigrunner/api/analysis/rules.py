"""The contract of rules for gross errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.data import Array


@dataclass(frozen=True)
class Rejection:
    """One value that a rule rejected, with its test statistic."""

    index: int
    value: float
    rule: str
    statistic: float
    critical: float


class OutlierRule(Protocol):
    """Finds gross errors in values that should agree."""

    def __call__(self, values: Array) -> Sequence[Rejection]:
        """Return what is rejected of values of shape (n,); the values stay as they are."""
        ...
