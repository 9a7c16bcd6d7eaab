"""Which torque a number is: a limit for one measurand says nothing of another (VIM 2.3)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Literal

from rigrunner.api import Force, Settings

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.measurands import ResultMeasurand
    from rigrunner.api.verdict import LimitDecision

LOAD_TOLERANCE = 0.01
"""How far a load may be from that of the limit, as a part of it."""
UNLOADED_N = 10.0
"""What a load cell may show of a bearing without load."""


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


class LimitMeasurand(Settings):
    """The torque that a limit applies to."""

    nature: Literal["load_induced", "total", "no_load"]
    """The torque that the load adds, the total under load, or the total without load."""
    condition: Literal["at_reversal", "from_rest", "under_way"]
    """At the reversals of a swing, at the first movement after a rest, or as a mean on the way."""
    load: Force | None = None
    """The load at which it applies; if omitted, any load."""

    @property
    def kind(self) -> MeasurandKind:
        """Nature and condition."""
        return MeasurandKind(Nature(self.nature), Condition(self.condition))

    def __str__(self) -> str:
        """Return it in words: 'load-induced torque at the reversals of a swing under 1000 N'."""
        return str(self.kind) if self.load is None else f"{self.kind} under {self.load:g} N"

    def objection(self, measurand: ResultMeasurand, loads_n: Iterable[float] = ()) -> str:
        """Return why this is not the torque that was found under those loads; '' if it is."""
        loads = sorted(loads_n)
        fits = isinstance(measurand, MeasurandKind) and self._is_kind(measurand, loads)
        if fits and self.load is not None:
            tolerance_n = LOAD_TOLERANCE * self.load or UNLOADED_N
            fits = all(abs(load - self.load) <= tolerance_n for load in loads)
        if fits:
            return ""
        return f"the limit is for the {self}, and the result is the {measurand}{_under(loads)}"

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it; read back, it is the same."""
        written: dict[str, object] = {"nature": self.nature, "condition": self.condition}
        return written if self.load is None else {**written, "load": f"{self.load!r} N"}

    def document(self) -> dict[str, object]:
        """Return its part of `result.json`; the text has no load, which stands beside it."""
        load = None if self.load is None else {"value": self.load, "unit": "N"}
        parts = {"nature": self.nature, "condition": self.condition}
        return {**parts, "load": load, "text": str(self.kind)}

    def _is_kind(self, kind: MeasurandKind, loads: list[float]) -> bool:
        """Say whether that is this torque; the total one is the no-load one where nothing loads."""
        natures = {kind.nature}
        if kind.nature is Nature.TOTAL and all(load <= UNLOADED_N for load in loads):
            natures.add(Nature.NO_LOAD)
        return self.kind.nature in natures and self.kind.condition is kind.condition


def load_of(decision: LimitDecision) -> float | None:
    """Return the load in N that the limit of a decision is stated for; None for any, or none."""
    stated = decision.measurand
    return stated.load if isinstance(stated, LimitMeasurand) else None


def _under(loads_n: list[float]) -> str:
    if not loads_n:
        return ""
    low, high = loads_n[0], loads_n[-1]
    span = f"{low:.0f} N" if high - low <= LOAD_TOLERANCE * high else f"{low:.0f} N to {high:.0f} N"
    return f" under {span}"
