"""What a run will measure, and where: each recording and each row of its plan."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.member import Member, channel_of
from rigrunner.api.places import PlaceValue, is_at
from rigrunner.plan.actions import Phase

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner.api.analysis import NeededChannel
    from rigrunner.api.quantity import Quantity
    from rigrunner.plan.actions import Plan, PlannedRecording

_PLACE = TypeAdapter[Mapping[str, PlaceValue]](Mapping[str, PlaceValue])


class PlannedData(NamedTuple):
    """A recording or row that the run will make."""

    units: Mapping[str, str]
    """Of its channels, in SI."""
    coordinate_units: Mapping[str, str]
    """Of its set-points and coordinates; '' of one that has none."""
    place: Mapping[str, CoordinateValue]
    """The values of these, as far as they are known beforehand."""
    recording: PlannedRecording | None = None
    """Where it is recorded; None of a row."""

    def may_be_at(self, where: Mapping[str, Quantity | str]) -> bool:
        """Say whether it is at a place, as far as that is known."""
        unknown = self.coordinate_units.keys() - self.place.keys()
        return is_at({k: value for k, value in where.items() if k not in unknown}, self.place)


def planned_data(plan: Plan) -> Iterator[PlannedData]:
    """Yield each recording and each row that the run will make."""
    recordings = {each.record.name: each for each in plan.recordings}
    for step in plan.steps:
        action, of = step.action, step.coordinate_units
        setpoints, symbols = action.setpoints_and_units
        here = {name: of.get(name, "") for name in step.coordinates}
        if step.phase is not Phase.SETUP:  # both count from the begin of main
            cyclic = "Hz" in map(symbols.get, setpoints)
            here |= {"elapsed": "s", "cycles": ""} if cyclic else {"elapsed": "s"}
        here |= {name: symbols.get(name, "") for name in setpoints}
        values = {**step.coordinates, **setpoints}
        place = {
            name: CoordinateValue.of_si(value, here[name], step.written_in.get(name, ""))
            for name, value in values.items()
        }
        if recording := recordings.get(action.recording):
            record = recording.record
            members = [Member(record.role, name) for name in record.channels]
            channel_units: dict[str, str] = {member: record.units[member] for member in members}
            yield PlannedData(channel_units, here, place, recording)
        if statistics := action.statistics:
            units: dict[str, str] = {name: symbols[channel_of(name)] for name in statistics}
            yield PlannedData(units, here, place)
        if rows := action.rows:
            read: dict[str, str] = {name: rows.units[name] for name in rows.channels}
            names = {name: rows.units.get(name, "") for row in rows.setpoints[:1] for name in row}
            for row in rows.setpoints:
                moved = {
                    name: CoordinateValue.of_si(value, names[name], step.written_in.get(name, ""))
                    for name, value in row.items()
                    if setpoints.get(name) != value
                }
                yield PlannedData(read, {**here, **names}, {**place, **moved})


def measured_places(
    plan: Plan, settings: Mapping[str, Any], channels: Iterable[NeededChannel]
) -> Iterator[Mapping[str, CoordinateValue]]:
    """Yield each place at which the channels of an analysis are measured, as far as it is known."""
    where = where_of(settings)
    for planned in planned_data(plan):
        if has_all(planned, channels) and planned.may_be_at(where):
            yield planned.place


def has_all(planned: PlannedData, channels: Iterable[NeededChannel]) -> bool:
    """Return whether all channels are measured there, or set where that is enough."""
    return all(
        needed.name in planned.units
        or (needed.or_coordinate and needed.name in planned.coordinate_units)
        for needed in channels
    )


def where_of(settings: Mapping[str, Any]) -> Mapping[str, Quantity | str]:
    """Return where an analysis looks, as its key `where` says; anywhere if that is no place."""
    try:
        return _PLACE.validate_python(
            settings.get("where", {}) if isinstance(settings, Mapping) else {}
        )
    except ValidationError:
        return {}
