"""What the rules for gross errors need of a run; loads without numpy."""

from __future__ import annotations

from typing import Any

from rigrunner.api import Requirements

BLIND_OF_PAUTA = 10
"""The 3-sigma rule can reject none of so many values, or of fewer."""


def of_pauta(_: Any) -> Requirements:
    """Return what the rule `pauta` needs."""
    return Requirements(cycles=BLIND_OF_PAUTA + 1)
