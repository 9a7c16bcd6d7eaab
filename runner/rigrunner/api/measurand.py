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


class Validity(StrEnum):
    """What holds for every result of a kind of measurand; who reports it says it in words."""

    AT_REVERSAL = "at_reversal"
    """It is the torque at the reversals of a swing, not that from rest."""
    ZERO_LOAD_FRICTION = "zero_load_friction"
    """Friction that the bearing has without load is not in it."""
    SUPPORT_FRICTION = "support_friction"
    """It is assumed that the supports' friction grows with load by no more than is allowed for."""
    PROPORTIONAL = "proportional"
    """It is assumed that the friction is proportional to the load, by which its error counts."""
    OTHER_LIMITS = "other_limits"
    """Limits of the no-load breakaway torque are limits of another quantity."""


@dataclass(frozen=True)
class MeasurandKind:
    """Nature and condition: what a limit is for, and what a compensation yields."""

    nature: Nature
    condition: Condition

    @property
    def id(self) -> str:
        """The kind as a name for programs: 'load_induced.at_reversal'."""
        return f"{self.nature.value}.{self.condition.value}"

    @property
    def validity(self) -> tuple[Validity, ...]:
        """Conditions that hold for every result of this kind, in the order of reports."""
        if self.nature is not Nature.LOAD_INDUCED:
            return ()
        reversal = (Validity.AT_REVERSAL,) if self.condition is Condition.AT_REVERSAL else ()
        limits = (Validity.OTHER_LIMITS,)
        assumed = (Validity.ZERO_LOAD_FRICTION, Validity.SUPPORT_FRICTION, Validity.PROPORTIONAL)
        return (*reversal, *assumed, *limits)

    def __str__(self) -> str:
        """Return it in words: 'no-load torque from rest'."""
        return f"{NATURES[self.nature]} {CONDITIONS[self.condition]}"
