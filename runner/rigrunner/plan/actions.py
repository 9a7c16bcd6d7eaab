"""The steps of a plan: explicit, in SI units, with nothing left to look up."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.member import Member
    from rigrunner.api.planned import RecordingAction
    from rigrunner.api.readings import ReadingLimit
    from rigrunner.api.steps import Action
    from rigrunner.api.unit_tables import Unit
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


class Phase(StrEnum):
    """When a step is run: teardown always, also after a failure."""

    # In the order in which they are planned and run.
    SETUP = "setup"
    MAIN = "main"
    TEARDOWN = "teardown"


@dataclass(frozen=True)
class Terms:
    """When a step counts as done, and what follows if it is not."""

    timeout_s: float | None = None
    """How long it may take."""
    attempts: int = 1
    """How often it is tried, all in all."""
    continues: bool = False
    """Whether the run continues after the last failure."""
    limits: tuple[ValueLimit, ...] = ()
    """What its values may be; an action that judges them itself has them."""
    expected: tuple[ReadingLimit, ...] = ()
    """What its readings may be that are no numbers."""
    stops_at_limit: bool = True
    """Whether a value out of limits ends the run."""
    repeatable: bool = True
    """Whether it may be done twice; a pause inside one that may not aborts the run."""


@dataclass(frozen=True, slots=True)
class PlannedStep:
    """One explicit action of a plan."""

    within: str
    """Where it stands in the innermost of its points, or in the procedure if it has none."""
    phase: Phase
    action: Action
    text: str
    """What it does, in words with units, for terminals and reports."""
    estimated_s: float
    terms: Terms = field(default_factory=Terms)
    calls: tuple[str, ...] = ()
    """The calls that it is part of, the outermost first: each a path. A called procedure's teardown
    is run where it stands, and also if the run fails within that call."""
    points: tuple[str, ...] = ()
    """The set-points of sweeps and times of repetitions that it is part of, the outermost first."""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    """Counters and labels of the step and those around it, by name, the outermost first."""
    coordinate_units: Mapping[str, str] = field(default_factory=dict)
    """The units of those that have one."""
    written_in: Mapping[str, str] = field(default_factory=dict)
    """By drive and coordinate, the unit in which the procedure writes it, where it is not SI."""

    leaves: int = 0
    """Of a condition: how many of the steps that follow hang on it."""

    @property
    def path(self) -> str:
        """Where it stands in the procedure, such as 'main[1].sweep[3].record'."""
        return f"{self.points[-1]}{self.within}" if self.points else self.within

    @property
    def limits(self) -> tuple[ValueLimit, ...]:
        """What the values may be that it finds."""
        return self.action.checked_limits or self.terms.limits


@dataclass(frozen=True, kw_only=True)
class Interlock:
    """A channel that is watched throughout the run; values in its SI unit.

    Tripped outside `minimum` to `maximum`, by a faster change than `rate_per_s`, or if nothing
    could be read for `stale_s`.
    """

    name: str
    member: Member
    condition: str
    """What trips it, in words."""
    shown: Unit
    """The unit in which values are shown."""
    minimum: float = -inf
    maximum: float = inf
    rate_per_s: float | None = None
    stale_s: float | None = None
    debounce_s: float = 0.0
    hysteresis: float = 0.0
    latched: bool = False
    every_s: float = 0.1
    does: str = "abort"
    """forbid, pause, abort or make_safe."""
    forbids: tuple[Member, ...] = ()
    """Drives that may not be led away from their safe value."""
    overridable: bool = False


@dataclass(frozen=True)
class PlannedRecording:
    """A recording with the place that asks for it."""

    record: RecordingAction
    document: Document
    path: Path
    conditions: Sequence[str] = ()
    """All channels, 'role.name', that are read with it."""
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    """As of its step."""
    coordinate_units: Mapping[str, str] = field(default_factory=dict)

    @property
    def in_cycles(self) -> bool:
        """Whether the procedure states its length in cycles."""
        return bool(self.document.part((*self.path, "cycles")))


@dataclass(frozen=True)
class Plan:
    """The whole run, step by step, in order; teardown steps last."""

    steps: tuple[PlannedStep, ...]
    interlocks: tuple[Interlock, ...] = ()
    recordings: tuple[PlannedRecording, ...] = ()
    """All recordings with their places in the procedure."""

    @property
    def has_conditions(self) -> bool:
        """Whether steps may be left out: the plan is then what the run does at most."""
        return any(step.leaves for step in self.steps)

    @property
    def estimated_s(self) -> float:
        """The longest duration of the run in seconds, without waiting for people."""
        return sum(step.estimated_s for step in self.steps)
