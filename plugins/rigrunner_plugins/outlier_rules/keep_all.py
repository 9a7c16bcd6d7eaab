"""The rule `none`: every value stays."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api import Array, Rejection


def keep_all(values: Array) -> list[Rejection]:  # noqa: ARG001  (the contract gives the values)
    """Reject nothing."""
    return []
