"""Match the recordings of a mapping to the steps of a procedure."""

from __future__ import annotations

from dataclasses import dataclass
from math import isclose
from typing import TYPE_CHECKING, Any

from rigrunner.api.member import Member
from rigrunner.api.quantity import Quantity
from rigrunner.api.units import unit
from rigrunner.procedure.answers import AnswerError
from rigrunner.steps.ask import Ask
from rigrunner.steps.measure import Measure
from rigrunner.steps.record import Record
from rigrunner.steps.scan import Scan
from rigrunner.steps.zero import Zero
from rigrunner.yamlfile.problems import Problems, suggestion

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.steps import Action
    from rigrunner.procedure.answers import Expected
    from rigrunner.run.prepare import Planned
    from rigrunner.tools.importing.mapping import ImportMapping, LoadedMapping, RecordingEntry
    from rigrunner.yamlfile.document import Path

SET_POINT_TOLERANCE = 1e-6
"""Relative difference up to which two set-points are equal."""


@dataclass(frozen=True)
class Matched:
    """The parts of a mapping that belong to each step of a plan."""

    recordings: Mapping[int, int]
    """The index of the recording in the mapping, by the index of the step that records."""
    inputs: Mapping[str, str]
    """The accepted answers."""


def match(mapping: LoadedMapping, planned: Planned) -> Matched:
    """Return the matched recordings; raise InvalidFileError with all that does not match."""
    return _Matcher(mapping, planned).match()


class _Matcher:
    def __init__(self, mapping: LoadedMapping, planned: Planned) -> None:
        self._mapping: ImportMapping = mapping.model
        self._document = mapping.document
        self._planned = planned
        self._problems = Problems()
        self._records = {
            index: step.action
            for index, step in enumerate(planned.plan.steps)
            if isinstance(step.action, Record)
        }

    def match(self) -> Matched:
        if not self._records:
            what = self._planned.procedure.model.id
            self._complain(("procedure",), f"{what} records nothing: there is nothing to import")
        if self._planned.plan.has_conditions:
            message = "its procedure has conditions, and which steps were skipped is not known"
            self._complain(("procedure",), message, "import by one without 'when' and 'until'")
        self._problems.stop_if_any()
        self._channels()
        self._zeros()
        self._measures()
        self._set_points()
        self._conditions()
        self._same_samples()
        inputs = self._inputs()
        self._problems.stop_if_any()
        recordings = self._recordings()
        self._problems.stop_if_any()
        return Matched(recordings, inputs)

    def _complain(self, path: Path, message: str, hint: str = "", *, key: bool = False) -> None:
        self._problems.add(self._document, path, message, hint, key=key)

    def _channels(self) -> None:
        units: dict[Member, str] = {}
        for action in self._records.values():
            members = [Member(action.role, name) for name in action.channels]
            units |= {member: action.units[member] for member in members}
        for member, spec in self._mapping.channels.items():
            path: Path = ("channels", member)
            if member not in units:
                hint = suggestion(member, units, "it records")
                self._complain(path, "the procedure does not record this channel", hint, key=True)
                continue
            self._check_unit((*path, "unit"), spec.unit, units[member], member)
        for member in units:
            if member not in self._mapping.channels:
                self._complain(
                    ("channels",), f"the procedure records '{member}', but no column is given",
                    f"such as {member}: {{column: ..., unit: {units[member]}}}", key=True,
                )  # fmt: skip

    def _check_unit(self, path: Path, symbol: str, needed: str, member: str) -> None:
        dimension, expected = unit(symbol).dimension, unit(needed).dimension
        if dimension != expected:
            text = f"'{symbol}' is a unit of {dimension}, but {member} needs one of {expected}"
            self._complain(path, text)

    def _zeros(self) -> None:
        steps = [step.action for step in self._planned.plan.steps if isinstance(step.action, Zero)]
        zeroed = [action.zeroed for action in steps]
        for member in self._mapping.zeros:
            if member not in zeroed:
                hint = suggestion(member, zeroed, "it zeroes")
                self._complain(
                    ("zeros", member), "the procedure does not zero this channel", hint, key=True
                )
                continue
            needed = steps[zeroed.index(member)].unit
            for at, zero in self._mapping.zeros_of(member):
                if isinstance(zero, Quantity):
                    self._check_unit(at, zero.unit.symbol, needed, member)
                elif member not in self._mapping.channels:
                    self._complain(at, f"no column of '{member}' is given")
        for member in dict.fromkeys(zeroed):
            if member not in self._mapping.zeros:
                self._complain(
                    ("zeros",), f"the procedure zeroes '{member}', but its reading at rest is"
                    " missing",
                    "0 in its unit if the program had already subtracted it", key=True,
                )  # fmt: skip
            elif (count := len(self._mapping.zeros_of(member))) != zeroed.count(member):
                self._complain(
                    ("zeros", member),
                    f"the procedure zeroes it {zeroed.count(member)} times, given: {count}",
                    "give a list of its readings at rest, in this order",
                )

    def _measures(self) -> None:
        steps = [row for step in self._planned.plan.steps for row in _rows(step.action)]
        entries = self._mapping.measurements
        for index, (action, entry) in enumerate(zip(steps, entries, strict=False)):
            path: Path = ("measurements", index)
            if entry.name != action.name:
                self._complain((*path, "name"), f"the procedure measures '{action.name}' here")
            elif entry.values.keys() != set(action.channels):
                channels = ", ".join(action.channels)
                self._complain((*path, "values"), f"the procedure measures here: {channels}")
            else:
                for member, value in entry.values.items():
                    at: Path = (*path, "values", member)
                    self._check_unit(at, value.unit.symbol, action.units[member], member)
        for action in steps[len(entries) :]:
            text = f"the measurement '{action.name}' is missing, of {', '.join(action.channels)}"
            self._complain(("measurements",), text, key=True)
        for index in range(len(steps), len(entries)):
            text = "the procedure measures nothing, or nothing more"
            self._complain(("measurements", index), text)

    def _set_points(self) -> None:
        units: dict[str, str] = {}
        for action in self._records.values():
            units |= {member: action.units[member] for member in action.setpoints}
        for path, set_points in self._values_of_key("set_points"):
            for member, quantity in set_points.items():
                at: Path = (*path, member)
                if member not in units:
                    hint = suggestion(member, units, "it sets")
                    self._complain(at, "the procedure does not set this drive", hint, key=True)
                else:
                    self._check_unit(at, quantity.unit.symbol, units[member], member)

    def _values_of_key(self, key: str) -> Iterator[tuple[Path, Mapping[Member, Any]]]:
        """Yield what a key states for all recordings, and then for each, with its place."""
        yield (key,), getattr(self._mapping, key)
        for index, entry in enumerate(self._mapping.recordings):
            yield ("recordings", index, key), getattr(entry, key)

    def _conditions(self) -> None:
        units: dict[str, str] = {}
        for role, device in self._planned.devices.items():
            units |= {Member(role, channel.name): channel.unit for channel in device.channels}
            units |= {Member(role, drive.name): drive.unit for drive in device.drives}
        for path, conditions in self._values_of_key("conditions"):
            for member, condition in conditions.items():
                at: Path = (*path, member)
                if member in self._mapping.channels:
                    self._complain(at, "this channel is recorded already", key=True)
                elif member not in units:
                    hint = suggestion(member, units, "there are")
                    self._complain(at, "the station has no such channel", hint, key=True)
                else:
                    symbol = (
                        condition.unit.symbol if isinstance(condition, Quantity) else condition.unit
                    )
                    self._check_unit(at, symbol, units[member], member)

    def _same_samples(self) -> None:
        """Report samples that are used for two recordings, as when a line was copied."""
        entries = self._mapping.recordings
        for index, entry in enumerate(entries):
            earlier = next((i for i in range(index) if entry.overlaps(entries[i])), None)
            if earlier is not None:
                self._complain(
                    ("recordings", index, "file"), f"recordings[{earlier}] has the same samples"
                )

    def _inputs(self) -> dict[str, str]:
        expected: dict[str, Expected] = {
            name: definition.expected for name, definition in self._planned.procedure.inputs.items()
        }
        for step in self._planned.plan.steps:
            if isinstance(step.action, Ask):
                expected[step.action.into] = step.action.expected
        answers: dict[str, str] = {}
        for name, answer in self._mapping.inputs.items():
            path: Path = ("inputs", name)
            if name not in expected:
                hint = suggestion(name, expected, "it asks for")
                self._complain(path, "the procedure has no such input", hint, key=True)
                continue
            try:
                answers[name] = expected[name].accept(answer)
            except AnswerError as error:
                self._complain(path, error.message, error.hint)
        for name in expected:
            if name not in self._mapping.inputs:
                self._complain(("inputs",), f"the answer to '{name}' is missing", key=True)
        return answers

    def _recordings(self) -> dict[int, int]:
        remaining = dict(enumerate(self._mapping.recordings))
        matches: dict[int, int] = {}
        missing: list[str] = []
        for step, action in self._records.items():
            index = next((i for i, entry in remaining.items() if self._is_at(entry, action)), None)
            if index is None:
                points = action.setpoints.items()
                at = (f"{drive} {value:g} {action.units[drive]}" for drive, value in points)
                missing.append(", ".join(at))
            else:
                matches[step] = index
                del remaining[index]
        for text in missing:
            self._complain(("recordings",), f"there is no recording at {text}", key=True)
        for index, entry in remaining.items():
            self._complain(("recordings", index), self._unmatched_text(entry))
        return matches

    def _is_at(self, entry: RecordingEntry, action: Record) -> bool:
        set_points = {**self._mapping.set_points, **entry.set_points}
        return set_points.keys() >= action.setpoints.keys() and all(
            isclose(set_points[Member.parse(drive)].si, value, rel_tol=SET_POINT_TOLERANCE)
            for drive, value in action.setpoints.items()
        )

    def _unmatched_text(self, entry: RecordingEntry) -> str:
        set_points = {**self._mapping.set_points, **entry.set_points}
        action = next(iter(self._records.values()))
        unset = [member for member in action.setpoints if member not in set_points]
        if unset:
            return f"the set-point is missing of: {', '.join(unset)}"
        text = ", ".join(f"{member} {quantity}" for member, quantity in set_points.items())
        return f"the procedure records nothing, or nothing more, at {text}"


def _rows(action: Action) -> Sequence[Measure | Scan]:
    """Return an action as often as it gives a row of a table."""
    match action:
        case Measure():
            return (action,)
        case Scan():
            return (action,) * len(action.values)
        case _:
            return ()
