"""Which torque a number is: a limit for one measurand says nothing of another (VIM 2.3)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Nature(StrEnum):
    """Which part of the bearing's torque."""

    LOAD_INDUCED = "load_induced"
    """What the load adds; friction that the bearing has without load is not in it."""
    TOTAL = "total"
    """All that the bearing resists with, under the load of the moment."""
    NO_LOAD = "no_load"
    """All that the bearing resists with while nothing loads it."""


class Condition(StrEnum):
    """In which motion."""

    AT_REVERSAL = "at_reversal"
    """Where a swing turns back."""
    FROM_REST = "from_rest"
    """At the first movement after a rest."""
    UNDER_WAY = "under_way"
    """The mean over the way of a swing."""


NATURES = {
    Nature.LOAD_INDUCED: "load-induced torque",
    Nature.TOTAL: "total torque",
    Nature.NO_LOAD: "no-load torque",
}
CONDITIONS = {
    Condition.AT_REVERSAL: "at the reversals of a swing",
    Condition.FROM_REST: "from rest",
    Condition.UNDER_WAY: "under way",
}


@dataclass(frozen=True)
class MeasurandKind:
    """Nature and condition: what a limit is for, and what a compensation yields."""

    nature: Nature
    condition: Condition

    def __str__(self) -> str:
        """Return it in words: 'no-load torque from rest'."""
        return f"{NATURES[self.nature]} {CONDITIONS[self.condition]}"
