"""A plan in the making: what is written down, and from which place of which file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rigrunner.api.coordinates import has_display_unit
from rigrunner.api.quantity import LONGEST_S, readable
from rigrunner.api.steps import NONE
from rigrunner.plan.actions import PlannedStep, Terms

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Mapping
    from pathlib import Path as Folder

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.steps import Action
    from rigrunner.plan.actions import Phase, PlannedRecording
    from rigrunner.plan.bench import Bench
    from rigrunner.plan.drives import DriveStates
    from rigrunner.procedure.answers import Expected
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems

_T = TypeVar("_T")
_TERMS = Terms()


class Place(NamedTuple):
    """A step in its file, and in the run, where steps within others come several times."""

    # A tuple: each step of a loop has several places, and a dataclass takes three times as long.
    phase: Phase
    path: Path
    within: str
    """As `within` of a PlannedStep."""
    calls: tuple[str, ...] = ()
    points: tuple[str, ...] = ()
    coordinates: Mapping[str, Coordinate] = NONE
    """Counters and labels that hold here, by name, the outermost first."""
    coordinate_units: Mapping[str, str] = NONE
    written_in: Mapping[str, str] = NONE
    """The units in which coordinates are written, where that is not SI."""

    @property
    def label(self) -> str:
        """The whole place in the run, as `path` of a PlannedStep."""
        return f"{self.points[-1]}{self.within}" if self.points else self.within

    def inside(self, *parts: str) -> Place:
        """Return the place of a part of the step."""
        within = ".".join((self.within, *parts))
        return self._replace(path=(*self.path, *parts), within=within)

    def step(self, index: int) -> Place:
        """Return the place of a step in the list that stands here."""
        return self._replace(path=(*self.path, index), within=f"{self.within}[{index}]")

    def time(self, index: int) -> Place:
        """Return the place of steps repeated for the n-th time; in the file it is the same."""
        return self._replace(within="", points=(*self.points, f"{self.label}[{index}]"))

    def outside(self) -> Place:
        """Return the same place, no longer as a part of the innermost set-point or time."""
        outer = self._replace(within="", points=self.points[:-1])
        return outer._replace(within=self.label.removeprefix(outer.label))

    def at(self, name: str, value: Coordinate, unit: str = "", written_in: str = "") -> Place:
        """Return the same place with a coordinate more."""
        written = (
            {name: written_in} if written_in and has_display_unit(written_in, unit or "1") else {}
        )
        units = {**self.coordinate_units, name: unit} if unit else self.coordinate_units
        return self._replace(
            coordinates={**self.coordinates, name: value},
            coordinate_units=units,
            written_in={**self.written_in, **written},
        )


@dataclass(eq=False)
class Draft:
    """What is written down of a plan so far."""

    recordings_total: int
    """How many recordings the procedure has, including those with problems."""
    steps: list[PlannedStep] = field(default_factory=list)
    recordings: list[PlannedRecording] = field(default_factory=list)
    answered: dict[str, Expected] = field(default_factory=dict)
    """The inputs that have an answer by then, and what is allowed as one."""
    latest: dict[Hashable, Any] = field(default_factory=dict)
    """What a step of a file had the last time that it was written down, as far as it is kept."""
    repeated: Counter[Hashable] = field(default_factory=Counter)
    """How often each step was written down that counts by itself how often it is done."""
    coordinates: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Of each name of a counter or label: what kind its values are, and where it is first given."""


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

    def coordinate(self, place: Place, name: str, kind: str, path: Path) -> bool:
        """Say whether a name can be given to a value here; add the problem if not.

        `kind` is what its values are, in a word: of one name all are of one kind.
        """
        where = str(self.document.where(path))
        first, at = self.draft.coordinates.setdefault(name, (kind, where))
        if first != kind:
            message = f"the kind of '{name}' is {kind} here and {first} at {at}"
            self.complain(path, message, "values of one name must be comparable: use two names")
        elif name in place.coordinates:
            message = f"a step around this one gives '{name}' already"
            self.complain(path, message, "choose another name")
        else:
            return True
        return False

    def shared(self, place: Place, name: str, part: _T) -> _T:
        """Return what a step in a loop had the last time, if it is the same: it is stored once."""
        where = (id(self.document), place.path, name)
        last: _T = self.draft.latest.setdefault(where, part)
        if last == part:
            return last
        self.draft.latest[where] = part
        return part

    def cached(self, place: Place, what: Hashable, make: Callable[[], _T]) -> _T:
        """Return what a step has each time that it is planned; it is computed the first time."""
        where = (id(self.document), place.path, what)
        if where not in self.draft.latest:
            self.draft.latest[where] = make()
        part: _T = self.draft.latest[where]
        return part

    def emit(
        self, place: Place, action: Action, text: str, seconds: float, terms: Terms = _TERMS
    ) -> None:
        """Write down one step; one that takes longer than any may is a problem."""
        if seconds > LONGEST_S:
            most = readable(LONGEST_S, "time")
            self.complain(place.path, f"it would take {seconds:.3g} s; the limit is {most}")
        written = {
            **(self.bench.shown_in if action.reads else {}),
            **self.drives.written(),
            **place.written_in,
        }
        within, written = self.shared(place, "written", (place.within, written))
        step = PlannedStep(
            within,
            place.phase,
            action,
            self.shared(place, "text", text),
            seconds,
            self.shared(place, "terms", terms),
            place.calls,
            place.points,
            place.coordinates,
            place.coordinate_units,
            written,
        )
        self.draft.steps.append(step)
