"""A plan in the making: what is written down, and from which place of which file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.quantity import LONGEST_S, readable
from rigrunner.plan.actions import PlannedStep

if TYPE_CHECKING:
    from pathlib import Path as Folder

    from rigrunner.api.steps import Action
    from rigrunner.plan.actions import Phase, Recorded, Terms
    from rigrunner.plan.bench import Bench
    from rigrunner.plan.drives import DriveStates
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems


@dataclass(frozen=True)
class Place:
    """A step in its file, and in the run, where steps within others come several times."""

    phase: Phase
    path: Path
    label: str
    calls: tuple[str, ...] = ()
    points: tuple[str, ...] = ()

    def inside(self, *parts: str) -> Place:
        """Return the place of a part of the step."""
        return self._at((*self.path, *parts), ".".join((self.label, *parts)), self.points)

    def step(self, index: int) -> Place:
        """Return the place of a step in the list that stands here."""
        return self._at((*self.path, index), f"{self.label}[{index}]", self.points)

    def time(self, index: int) -> Place:
        """Return the place of steps done for the so-manieth time; in the file it is the same."""
        label = f"{self.label}[{index}]"
        return self._at(self.path, label, (*self.points, label))

    def _at(self, path: Path, label: str, points: tuple[str, ...]) -> Place:
        return Place(self.phase, path, label, self.calls, points)


@dataclass(eq=False)
class Draft:
    """What is written down of a plan so far."""

    wanted: int
    """How many recordings are asked for; those with problems never come to be."""
    steps: list[PlannedStep] = field(default_factory=list)
    recordings: list[Recorded] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Scene:
    """What it takes to plan the steps of one procedure file."""

    document: Document
    folder: Folder
    """Where the files are that it names."""
    bench: Bench
    drives: DriveStates
    problems: Problems
    draft: Draft

    def complain(self, path: Path, message: str, hint: str = "", *, key: bool = False) -> None:
        """Add a problem with the value (or key) at a path of this file."""
        self.problems.add(self.document, path, message, hint, key=key)

    def emit(self, place: Place, action: Action, text: str, seconds: float, terms: Terms) -> None:
        """Write down one step; one that takes longer than any may is a problem."""
        if seconds > LONGEST_S:
            most = readable(LONGEST_S, "time")
            self.complain(place.path, f"it would take {seconds:.3g} s, allowed is at most {most}")
        step = PlannedStep(
            place.label, place.phase, action, text, seconds, terms, place.calls, place.points
        )
        self.draft.steps.append(step)
