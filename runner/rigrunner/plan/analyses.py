"""Whether a run will measure what its analyses need; checked before the rig moves."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from itertools import combinations, pairwise
from typing import TYPE_CHECKING

from pydantic import ValidationError

from rigrunner.api.analysis.requirements import SPARE_CYCLES
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.errors import PluginError, did_you_mean
from rigrunner.api.fit_choice import FitChoice
from rigrunner.api.member import channel_of
from rigrunner.api.units import of_difference, unit, with_article
from rigrunner.plan.limits import objections_to_limit
from rigrunner.plan.measured import has_all, planned_data, where_of
from rigrunner.procedure.named_results import all_named, definitions_of
from rigrunner.yamlfile.problems import Problems, suggestion

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigrunner.api.analysis import NeededChannel, NeededResult, Requirements
    from rigrunner.api.findings import ResultDefinition
    from rigrunner.plan.actions import Plan, PlannedRecording
    from rigrunner.plan.measured import PlannedData
    from rigrunner.procedure import AnalysisRef, Limit, LoadedProcedure
    from rigrunner.registry import Registry
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path

_SAME = 1e-6  # of the greater set-point
_ROUNDING = 1e-9
"""Of duration times frequency: 2.9999999999 cycles are 3."""


def check_analyses(
    procedure: LoadedProcedure, station: LoadedStation, plan: Plan, registry: Registry
) -> None:
    """Raise InvalidFileError with all that the analyses need and the run would not give."""
    problems = Problems()
    planned = tuple(planned_data(plan)) if procedure.model.analyses_at else ()
    limits = procedure.model.acceptance.limits if procedure.model.acceptance else ()
    limited = {limit.of for limit in limits}
    results = {each.name: (path, each) for path, each in definitions_of(procedure, registry)}
    complete = all_named(procedure, registry)
    uses: list[_Use] = []
    for path, plugin in procedure.model.analyses_at:
        try:
            needs = registry.requires("analysis", plugin.name, plugin.settings)
        except PluginError:
            continue  # reported by the check of the plugins
        uses.append(
            _Use(procedure, path, plugin, needs, planned, results, complete, registry, problems)
        )
    for use in uses:
        if use.has_results() and use.is_measured():
            use.check_units()
            use.check_coordinates()
            use.check_recordings()
            use.check_register(station, limited)
            use.check_limits(limits)
    _refuse_circles(uses)
    problems.stop_if_any()


@dataclass(frozen=True)
class _Use:
    """An analysis that a procedure asks for, and what the run will measure."""

    procedure: LoadedProcedure
    at: Path
    plugin: AnalysisRef
    needs: Requirements
    planned: tuple[PlannedData, ...]
    results: Mapping[str, tuple[Path, ResultDefinition]]
    """The results of the procedure by name, each with where the analysis stands that makes it."""
    knows_all: bool
    """Whether these are all: an analysis that is refused names none."""
    registry: Registry
    problems: Problems

    @property
    def channels(self) -> tuple[NeededChannel, ...]:
        """The channels that it needs."""
        return self.needs.channels

    def has_results(self) -> bool:
        """Add a problem for each needed result that it cannot have; say whether there is none."""
        complete = True
        for needed in self.needs.results:
            if needed.name not in self.results:
                complete = False
                if self.knows_all:
                    hint = suggestion(needed.name, self.results, "results")
                    self.complain(needed.key, f"there is no result '{needed.name}'", hint)
                continue
            per = self.results[needed.name][1].per
            omitted = [name for name in per if needed.per is not None and name not in needed.per]
            if omitted:
                message = f"there is a result '{needed.name}' for each {' and '.join(omitted)}"
                self.complain(needed.key, message, f"add it: 'per: [{', '.join(per)}]'")
                complete = False
            missing = next((name for name in needed.for_each if name not in per), "")
            if missing:
                message = f"there is no result '{needed.name}' for each {missing}"
                hint = f"write 'per: [{', '.join((*per, missing))}]' there"
                if not any(missing in planned.coordinate_units for planned in self.planned):
                    hint = f"{missing} is read, not set: name the result of a 'readings' of it"
                self.complain(needed.key, message, hint)
                complete = False
            reference = self.results.get(needed.for_each_of)
            if reference is not None and set(reference[1].per) != set(per):
                message = f"'{needed.name}' and '{needed.for_each_of}' have values at other places"
                hint = f"both need the same 'per': [{', '.join(reference[1].per)}]"
                self.complain(needed.key, message, hint)
                complete = False
        independent = [n for n in self.needs.results if n.independent and n.name in self.results]
        for one, other in combinations(independent, 2):
            if self.results[one.name][0] == self.results[other.name][0]:
                message = (
                    f"'{one.name}' and '{other.name}' are results of one analysis, with the same"
                    " scatter"
                )
                hint = "compute it there, where their correlation is known"
                self.complain(other.key, message, hint)
                complete = False
        return complete

    def is_measured(self) -> bool:
        """Add a problem for each channel that no step measures; say whether there is none."""
        names = sorted({name for planned in self.planned for name in planned.units})
        coordinates = sorted({name for each in self.planned for name in each.coordinate_units})
        missing = [
            each
            for each in self.channels
            if each.name not in names and not (each.or_coordinate and each.name in coordinates)
        ]
        for channel in missing:
            options = [*names, *(coordinates if channel.or_coordinate else ())]
            how = "measured or set" if channel.or_coordinate else "measured"
            hint = did_you_mean(channel.name, options, f"{how}: {', '.join(options) or 'nothing'}")
            where = (
                "not measured or set in any step"
                if channel.or_coordinate
                else "not measured in any step"
            )
            self.complain(channel.key, f"{channel.name} is {where}", hint)
        if missing or self.places or not self.channels:
            return not missing
        message = f"{self.channel_names} are not measured together in any step"
        self.problems.add(self.procedure.document, self.at, message, "name them in one step",
                          key=True)  # fmt: skip
        return False

    def check_units(self) -> None:
        """Add what does not fit the units of the channels and results."""
        unit_of: dict[str, str] = {}
        for planned in self.planned:
            # What is read goes before a set-point or label of its name.
            unit_of = {**planned.coordinate_units, **unit_of, **planned.units}
        units = {channel.name: unit_of[channel.name] for channel in self.channels}
        for channel in self.channels:
            dimension = unit(units[channel.name] or "1").dimension
            if channel.quantity not in {"", dimension}:
                message = f"{channel.name} is {with_article(dimension)}"
                self.complain(channel.key, message, f"expected {with_article(channel.quantity)}")
                return
        units |= {result.name: self.results[result.name][1].unit for result in self.needs.results}
        objections = self.registry.objections(self.plugin.name, self.plugin.settings, units)
        for key, message, hint, *column in objections:
            self.complain(key, message, hint, *column)

    def check_coordinates(self) -> None:
        """Add a problem for each coordinate that does not distinguish the results."""
        if not (self.channels or self.needs.results):
            return
        where = where_of(self.plugin.settings)
        definitions = self.registry.definitions(self.plugin.name, self.plugin.settings)
        per = sorted({name for each in definitions for name in each.per})
        if not self.channels:
            of_results = {name for result in self.needs.results for name in
                          self.results[result.name][1].per}  # fmt: skip
            for name in per:
                if name not in of_results:
                    message = f"'{name}' does not distinguish any of the results that it is made of"
                    self.complain(("per",), message, f"there are: {', '.join(sorted(of_results))}")
            return
        chosen = [each for each in self.places if each.may_be_at(where)]
        if not chosen:
            values = {
                f"{name} {each.place.get(name, '-')}" for each in self.places for name in where
            }
            message = f"no step measures {self.channel_names} there"
            self.complain(("where",), message, f"there are: {', '.join(sorted(values))}")
            return
        everywhere = frozenset.intersection(*(frozenset(each.coordinate_units) for each in chosen))
        for name in sorted(set(per) - everywhere):
            message = f"'{name}' is not set at every measurement of {self.channel_names}"
            hint = suggestion(name, sorted(everywhere), "set by then")
            self.complain(("per",), message, hint)
        for needed in self.channels:
            self._check_values(needed, chosen)
            self._check_shared(needed, chosen, per)
            self._check_set_points(needed, chosen, per)

    def _check_values(self, needed: NeededChannel, chosen: Iterable[PlannedData]) -> None:
        """Add a problem for the first required value at which nothing will be measured."""
        candidates = [each for each in chosen if needed.name in each.coordinate_units]
        for value in needed.values if candidates else ():
            if not any(each.may_be_at({needed.name: value}) for each in candidates):
                # Each has a place: one whose value is not known may be at any.
                values = sorted({str(each.place[needed.name]) for each in candidates})
                message = f"nothing is measured at {needed.name} = {value}"
                hint = suggestion(str(value), values, "there are")
                self.complain(needed.key, message, hint)
                return

    def _check_shared(
        self, needed: NeededChannel, chosen: Sequence[PlannedData], per: Iterable[str]
    ) -> None:
        """Add a problem if nowhere one set-point is set at all values of a label."""
        name = needed.shared
        if not name or any(name in each.units for each in chosen):
            return  # read
        groups = _set_points(name, chosen, per)
        for group in groups:
            values = [value for value, _ in group]
            width = needed.within * (max(values) - min(values))
            by_label = [
                sorted(value for value, place in group if place.may_be_at({needed.name: label}))
                for label in needed.values
            ]
            if any(all(_has_near(value, row, width) for row in by_label) for value in by_label[0]):
                return
        if groups:
            labels = " and ".join(map(str, needed.values))
            message = f"{name} is never the same at {needed.name} = {labels}"
            self.complain(needed.key, message, "set it to the same value at both")

    def _check_set_points(
        self, needed: NeededChannel, chosen: Iterable[PlannedData], per: Iterable[str]
    ) -> None:
        """Add a problem where set-points do not reach far enough, or are too few for a fit."""
        least = self._points_of_fit(needed)
        if needed.spans is None and not least:
            return
        symbol = next((planned.coordinate_units.get(needed.name, "") for planned in chosen), "")
        for group in _set_points(needed.name, chosen, per):
            values = {value for value, _ in group}
            low, high = min(values), max(values)
            if needed.spans is not None:
                first, last = needed.spans
                margin = _SAME * max(abs(low), abs(high))
                if first < low - margin or last > high + margin:
                    span = _from_to(first, last, symbol)
                    message = f"{needed.name} must reach {span}, but is set"
                    hint = "set it there too, or ask for values within it"
                    self.complain(needed.key, f"{message} {_from_to(low, high, symbol)}", hint)
                    return
            if len(values) < least:
                message = f"the fit needs {least} different values of {needed.name}"
                hint = "set more, or take a fit with fewer parameters"
                self.complain((needed.x_of,), f"{message}, got {len(values)}", hint)
                return

    def _points_of_fit(self, needed: NeededChannel) -> int:
        """Return how many different values of this x the fit needs; 0 without a fit."""
        choice = self.plugin.settings.get(needed.x_of) if needed.x_of else None
        if choice is None:
            return 0
        try:
            fit = FitChoice.model_validate(choice)
            return self.registry.requires("fit", fit.name, fit.settings).points
        except (PluginError, ValidationError):
            return 0  # reported by the check of the plugins

    def check_register(self, station: LoadedStation, limited: set[str]) -> None:
        """Add a problem for an instrument of another quantity than its channel.

        Its limits of error, such as 0.1 K, would be taken in the unit of the channel. So for a
        channel without an instrument that enters a result with a limit. A set-point that is not in
        the register counts as exact.
        """
        register = {each.channel: index for index, each in enumerate(station.model.instruments)}
        units = {name: of for each in self.planned for name, of in each.units.items()}
        for needed in self.channels:
            if needed.name not in units:
                continue
            channel, kind = channel_of(needed.name), unit(units[needed.name]).dimension
            if channel in register:
                index = register[channel]
                measures = station.model.instruments[index].quantity
                is_spread = channel != needed.name and kind == of_difference(measures)
                if kind != measures and not is_spread:
                    message = f"got {with_article(measures)}; {channel} is {with_article(kind)}"
                    hint = f"write 'measures: {kind}', and its accuracy as of {with_article(kind)}"
                    path: Path = ("instruments", index, "measures")
                    self.problems.add(station.document, path, message, hint)
                continue
            result = next((name for name in needed.enters if name in limited), None)
            if result is None:
                continue
            message = f"{channel} enters the result '{result}', which has a limit: there is no "
            hint = "enter its accuracy: {channel: " + channel + ", measures: ..., accuracy: ...}"
            self.problems.add(
                station.document, ("instruments",), message + "instrument for it", hint, key=True
            )

    def check_limits(self, limits: Iterable[Limit]) -> None:
        """Add a problem for each limit that cannot be applied where its result is measured."""
        where = where_of(self.plugin.settings)
        places = [each for each in self.places if each.may_be_at(where)] if self.channels else []
        for index, limit in enumerate(limits):
            at, definition = self.results.get(limit.of, ((), None))
            if definition is None or not places or at != self.at:
                continue
            for key, message, hint in objections_to_limit(limit, definition, places):
                path = ("acceptance", "limits", index, *key)
                self.problems.add(self.procedure.document, path, message, hint)

    def check_recordings(self) -> None:
        """Add a problem for each recording that is too slow, or has too few cycles."""
        needs, name = self.needs, f"the analysis '{self.plugin.name}'"
        if not (needs.rate_hz or needs.cycles):
            return
        where = where_of(self.plugin.settings)
        chosen = [each.recording for each in self.places if each.may_be_at(where)]
        recordings = [each for each in chosen if each is not None]
        if not recordings:
            message = f"{name} needs a recording, but only single values are measured"
            self.complain((), message, "add a record step")
        for recorded in recordings:
            rate_hz = recorded.record.sample_rate_hz
            if rate_hz is not None and rate_hz < needs.rate_hz:
                message = f"{name} needs at least {needs.rate_hz:g} samples per second"
                message += f", got {rate_hz:g}"
                at, hint = recorded.path, "sample faster"
                self.problems.add(recorded.document, at, message, hint, key=True)
            if needs.cycles:
                self._check_cycles(recorded, name)

    def _check_cycles(self, recorded: PlannedRecording, name: str) -> None:
        """Ask for enough whole cycles: a recording is of one period more than it has whole ones."""
        record = recorded.record
        frequency_hz = record.cycle_frequency_hz or 0.0
        cycles = int(record.duration_s * frequency_hz + _ROUNDING) - 1
        least = self.needs.cycles + SPARE_CYCLES
        if cycles >= least:
            return
        count = str(cycles) if recorded.in_cycles else f"{max(cycles, 0)} at {frequency_hz:g} Hz"
        message = f"{name} needs at least {least} cycles in each recording, got {count}"
        hint = f"{self.needs.cycles} whole cycles and one more are needed"
        path = (*recorded.path, "cycles" if recorded.in_cycles else "duration")
        self.problems.add(recorded.document, path, message, hint)

    @property
    def places(self) -> list[PlannedData]:
        """The recordings and rows with all needed channels."""
        return [planned for planned in self.planned if has_all(planned, self.channels)]

    @property
    def channel_names(self) -> str:
        """The names of the channels, in words."""
        return " and ".join(dict.fromkeys(channel.name for channel in self.channels))

    def complain(
        self, key: tuple[str | int, ...], message: str, hint: str, column: int = 0
    ) -> None:
        """Add a problem with what stands under a key of the settings."""
        document, path = self.procedure.document, (*self.at, *key)
        self.problems.add(document, path, message, hint, column=column)


def _set_points(
    name: str, chosen: Iterable[PlannedData], per: Iterable[str]
) -> list[list[tuple[float, PlannedData]]]:
    """Return the values in SI that are set, with the data planned there, for each place of `per`.

    Empty if one is not known beforehand, or is a text.
    """
    groups: dict[tuple[CoordinateValue, ...], list[tuple[float, PlannedData]]] = {}
    for planned in chosen:
        place = planned.place
        point = place.get(name)
        if point is None or isinstance(point.value, str) or any(n not in place for n in per):
            return []
        key = tuple(place[n].usual for n in per)
        si = unit(point.unit or "1").to_si(point.value)
        groups.setdefault(key, []).append((si, planned))
    return [*groups.values()]


def _has_near(value: float, ascending: Sequence[float], width: float) -> bool:
    at = bisect_left(ascending, value - width)
    return at < len(ascending) and ascending[at] <= value + width


def _refuse_circles(uses: Iterable[_Use]) -> None:
    """Add a problem where results are made of each other."""
    by_place = {use.at: use for use in uses}
    needed: dict[Path, dict[Path, NeededResult]] = {
        at: {use.results[n.name][0]: n for n in use.needs.results if n.name in use.results}
        for at, use in by_place.items()
    }
    try:
        TopologicalSorter({at: sorted(of, key=str) for at, of in needed.items()}).prepare()
    except CycleError as error:
        circle: list[Path] = error.args[1]  # each is needed by the next, the last is the first
        of, at = circle[-2], circle[-1]
        chain = " -> ".join(dict.fromkeys(needed[b][a].name for a, b in pairwise(circle)))
        use, result = by_place[at], needed[at][of]
        message = f"'{result.name}' is computed from this result itself: {chain}"
        use.complain(result.key, message, "name a channel, or a result that needs none of these")


def _from_to(low: float, high: float, symbol: str) -> str:
    """Return '1 A to 2 A' of values in an SI unit, temperatures in °C."""
    ends = [str(CoordinateValue.of_si(end, symbol)) for end in (low, high)]
    return f"{ends[0]} to {ends[1]}" if low < high else ends[0]
