"""Whether a run will measure what its analyses need, asked before the rig moves."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from pydantic import TypeAdapter, ValidationError

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.errors import PluginError
from rigrunner.api.member import Member, channel_of
from rigrunner.api.places import PlaceValue, is_at
from rigrunner.plan.actions import Phase
from rigrunner.yamlfile.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner.api.findings import NeededChannel, Objection, ResultDefinition
    from rigrunner.api.quantity import Quantity
    from rigrunner.plan.actions import Plan
    from rigrunner.procedure import LoadedProcedure, NamedAnalysisRef
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile.document import Path

_PLACE = TypeAdapter[Mapping[str, PlaceValue]](Mapping[str, PlaceValue])


class Measured(NamedTuple):
    """A recording or row that the run will make."""

    units: Mapping[str, str]
    """Of its channels, in SI."""
    coordinate_units: Mapping[str, str]
    """Of its set-points and coordinates; '' of one that has none."""
    place: Mapping[str, CoordinateValue]
    """The values of these, as far as they are known beforehand."""

    def may_be_at(self, where: Mapping[str, Quantity | str]) -> bool:
        """Say whether it is at a place, as far as that is known."""
        unknown = self.coordinate_units.keys() - self.place.keys()
        return is_at({k: each for k, each in where.items() if k not in unknown}, self.place)


class AnalysisLookup(Protocol):
    """Knows what each analysis needs and names."""

    def definitions(self, name: str, settings: Mapping[str, Any]) -> tuple[ResultDefinition, ...]:
        """Return the results that it names; raise PluginError."""
        ...

    def channels_of(self, name: str, settings: Mapping[str, Any]) -> tuple[NeededChannel, ...]:
        """Return the channels that it needs; raise PluginError."""
        ...

    def objections(
        self, name: str, settings: Mapping[str, Any], units: Mapping[str, str]
    ) -> tuple[Objection, ...]:
        """Return what does not fit the units of these channels; raise PluginError."""
        ...


def check_analyses(
    procedure: LoadedProcedure, station: LoadedStation, plan: Plan, lookup: AnalysisLookup
) -> None:
    """Raise InvalidFileError with all that the analyses need and the run would not give."""
    problems = Problems()
    measured = tuple(_measured(plan))
    judged = procedure.model.acceptance.limits if procedure.model.acceptance else ()
    limited = {limit.of for limit in judged}
    for path, plugin in procedure.model.named_analyses_at:
        try:
            needed = lookup.channels_of(plugin.name, plugin.settings)
        except PluginError:
            continue  # told by the check of the plugins
        use = _Use(procedure, (*path, plugin.name), plugin, needed, measured, problems)
        if use.is_measured():
            use.check_units(lookup)
            use.check_coordinates(lookup)
            _check_register(station, needed, limited, problems)
    problems.stop_if_any()


@dataclass(frozen=True)
class _Use:
    """An analysis that a procedure asks for, and what the run will measure."""

    procedure: LoadedProcedure
    at: Path
    plugin: NamedAnalysisRef
    needed: tuple[NeededChannel, ...]
    measured: tuple[Measured, ...]
    problems: Problems

    def is_measured(self) -> bool:
        """Add a problem for each channel that no step measures; say whether there is none."""
        names = sorted({name for each in self.measured for name in each.units})
        coordinates = sorted({name for each in self.measured for name in each.coordinate_units})
        missing = [
            each
            for each in self.needed
            if each.name not in names and not (each.or_coordinate and each.name in coordinates)
        ]
        for each in missing:
            known = [*names, *(coordinates if each.or_coordinate else ())]
            near = difflib.get_close_matches(each.name, known, n=1)
            listed = f"measured{' or set' * each.or_coordinate}: {', '.join(known) or 'nothing'}"
            hint = f"did you mean '{near[0]}'?" if near else listed
            how = "measured or set" if each.or_coordinate else "measured"
            self.complain(each.key, f"{each.name} is {how} in no step", hint)
        if missing or self.places:
            return not missing
        message = f"{self.together} are measured in no step together"
        self.problems.add(self.procedure.document, self.at, message, "name them in one step",
                          key=True)  # fmt: skip
        return False

    def check_units(self, lookup: AnalysisLookup) -> None:
        """Add what does not fit the units of the channels."""
        known: dict[str, str] = {}
        for measured in self.measured:
            known = {**measured.coordinate_units, **known, **measured.units}
        units = {each.name: known[each.name] for each in self.needed}
        told = self.plugin.settings
        for key, message, hint, *column in lookup.objections(self.plugin.name, told, units):
            self.complain(key, message, hint, *column)

    def check_coordinates(self, lookup: AnalysisLookup) -> None:
        """Add a problem for each coordinate by which results cannot be told apart."""
        where = _where(self.plugin.settings)
        chosen = [each for each in self.places if each.may_be_at(where)]
        if not chosen:
            known = {
                f"{name} {each.place.get(name, '-')}" for each in self.places for name in where
            }
            message = f"{self.together} is not measured there"
            self.complain(("where",), message, f"there are: {', '.join(sorted(known))}")
            return
        everywhere = frozenset.intersection(*(frozenset(each.coordinate_units) for each in chosen))
        named = lookup.definitions(self.plugin.name, self.plugin.settings)
        for name in sorted({name for each in named for name in each.per} - everywhere):
            near = difflib.get_close_matches(name, everywhere, n=1)
            listed = f"set by then: {', '.join(sorted(everywhere)) or 'none'}"
            message = f"'{name}' is not set wherever {self.together} is measured"
            self.complain(("per",), message, f"did you mean '{near[0]}'?" if near else listed)

    @property
    def places(self) -> list[Measured]:
        """What has all needed channels."""
        return [
            found
            for found in self.measured
            if all(
                each.name in found.units
                or (each.or_coordinate and each.name in found.coordinate_units)
                for each in self.needed
            )
        ]

    @property
    def together(self) -> str:
        """The channels, in words."""
        return " and ".join(each.name for each in self.needed)

    def complain(
        self, key: tuple[str | int, ...], message: str, hint: str, column: int = 0
    ) -> None:
        """Add a problem with what stands under a key of the settings."""
        document, path = self.procedure.document, (*self.at, *key)
        self.problems.add(document, path, message, hint, column=column)


def _measured(plan: Plan) -> Iterator[Measured]:
    recordings = {each.record.name: each.record for each in plan.recordings}
    for step in plan.steps:
        action, of = step.action, step.coordinate_units
        setpoints, symbols = action.known
        here = {name: of.get(name, "") for name in step.coordinates}
        if step.phase is not Phase.SETUP:
            cyclic = "Hz" in map(symbols.get, setpoints)
            here |= {"elapsed": "s", "cycles": ""} if cyclic else {"elapsed": "s"}
        here |= {name: symbols.get(name, "") for name in setpoints}
        values = {**step.coordinates, **setpoints}
        place = {
            name: CoordinateValue.of_si(value, here[name], step.written_in.get(name, ""))
            for name, value in values.items()
        }
        if record := recordings.get(action.recording):
            members = [Member(record.role, name) for name in record.channels]
            known: dict[str, str] = {member: record.units[member] for member in members}
            yield Measured(known, here, place)
        if found := action.statistics:
            units: dict[str, str] = {name: symbols[channel_of(name)] for name in found}
            yield Measured(units, here, place)
        if rows := action.rows:
            read: dict[str, str] = {name: rows.units[name] for name in rows.channels}
            for each in rows.setpoints[:1]:
                names = {name: rows.units.get(name, "") for name in each}
                fixed = {name: at for name, at in place.items() if name != action.led}
                yield Measured(read, {**here, **names}, fixed)


def _where(settings: Mapping[str, Any]) -> Mapping[str, Quantity | str]:
    """Return where an analysis looks, as its key `where` says; anywhere if that is no place."""
    try:
        return _PLACE.validate_python(settings.get("where", {}))
    except ValidationError:
        return {}


def _check_register(
    station: LoadedStation, needed: Iterable[NeededChannel], limited: set[str], problems: Problems
) -> None:
    """Add a problem for a channel that enters a result with a limit, and is not in the register.

    A set-point that is not in the register counts as exact.
    """
    register = {each.channel for each in station.model.instruments}
    for each in needed:
        result = next((name for name in each.enters if name in limited), None)
        if result is None or each.or_coordinate:
            continue
        channel = channel_of(each.name)
        if channel in register:
            continue
        message = f"{channel} enters the result '{result}', which has a limit: there is no "
        hint = "enter its accuracy: {channel: " + channel + ", measures: ..., accuracy: ...}"
        problems.add(
            station.document, ("instruments",), message + "instrument for it", hint, key=True
        )
