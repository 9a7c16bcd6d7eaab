"""From the interlocks of station and procedures to those of the plan, in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.devices import Readable, Streaming
from rigrunner.api.units import of_difference, rate_of, unit
from rigrunner.plan.actions import Interlock
from rigrunner.plan.safety import wrong_dimension
from rigrunner.yamlfile.problems import suggestion

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.api.devices import ChannelInfo, Device
    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Quantity
    from rigrunner.interlock import Interlock as Written
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path
    from rigrunner.yamlfile.problems import Problems


def plan_interlocks(
    procedure: LoadedProcedure | None,
    station: LoadedStation,
    devices: Mapping[str, Device],
    problems: Problems,
) -> tuple[Interlock, ...]:
    """Return the interlocks of station, procedure and all that it calls; they hold all the time.

    Without a procedure, as by hand, those of the station.
    """
    interlocks: dict[str, Interlock] = {}
    for place in _places(procedure, station, devices, problems):
        if place.written.name in interlocks:
            place.complain("name", f"another interlock is called '{place.written.name}'")
        interlock = place.to_si()
        if interlock is not None:
            interlocks[interlock.name] = interlock
    return tuple(interlocks.values())


def _places(
    procedure: LoadedProcedure | None,
    station: LoadedStation,
    devices: Mapping[str, Device],
    problems: Problems,
) -> Iterator[_Place]:
    of_station = station.model.safety.interlocks
    sources: list[tuple[Document, Path, Iterable[Written]]] = [
        (station.document, ("safety", "interlocks"), of_station)
    ]
    used = () if procedure is None else (procedure, *procedure.all_called())
    # A procedure that is called twice has its interlocks once.
    different = {each.document.name: each for each in used}.values()
    sources += [(each.document, ("interlocks",), each.model.interlocks) for each in different]
    for document, path, interlocks in sources:
        for index, written in enumerate(interlocks):
            yield _Place(written, document, (*path, index), devices, problems)


@dataclass(frozen=True, eq=False)
class _Place:
    """An interlock where it is written."""

    written: Written
    document: Document
    path: Path
    devices: Mapping[str, Device]
    problems: Problems

    def complain(self, key: str | int, message: str, hint: str = "", *more: str | int) -> None:
        self.problems.add(self.document, (*self.path, key, *more), message, hint)

    def to_si(self) -> Interlock | None:
        """Return the interlock in SI units; None after adding what is wrong with it."""
        written = self.written
        for index, member in enumerate(written.forbids):
            device = self._device(member, "forbids", index)
            drives = [] if device is None else [info.name for info in device.drives]
            if device is not None and member.name not in drives:
                message = f"the device in the role '{member.role}' has no drive '{member.name}'"
                self.complain("forbids", message, suggestion(member.name, drives, "drives"), index)
        channel = self._channel()
        if channel is None or not self._fits(channel):
            return None
        bounds = {name: quantity.si for name, quantity in written.bounds.items()}
        shown = next(iter(written.bounds.values())).unit if bounds else unit(channel.unit)
        return Interlock(
            name=written.name,
            member=written.channel,
            condition=written.condition,
            shown=shown,
            minimum=bounds.get("minimum", -math.inf),
            maximum=bounds.get("maximum", math.inf),
            rate_per_s=written.rate.si if written.rate else None,
            stale_s=written.stale,
            debounce_s=written.debounce,
            hysteresis=written.hysteresis.si if written.hysteresis else 0.0,
            latched=written.latched,
            every_s=written.every,
            does=written.does,
            forbids=written.forbids,
            overridable=written.overridable,
        )

    def _channel(self) -> ChannelInfo | None:
        device = self._device(self.written.channel, "channel")
        if device is None:
            return None
        role, name = self.written.channel.role, self.written.channel.name
        if not isinstance(device, (Readable, Streaming)):
            self.complain("channel", f"the device in the role '{role}' has nothing to be read")
        channels = {info.name: info for info in device.channels}
        if name not in channels:
            message = f"the device in the role '{role}' has no channel '{name}'"
            self.complain("channel", message, suggestion(name, channels, "channels"))
        return channels.get(name)

    def _device(self, member: Member, key: str, *more: int) -> Device | None:
        role = member.role
        if role not in self.devices:
            message = f"the station has no device in the role '{role}'"
            self.complain(key, message, suggestion(role, self.devices, "roles"), *more)
        return self.devices.get(role)

    def _fits(self, channel: ChannelInfo) -> bool:
        """Return whether all quantities have the dimension of the channel, or of its rate."""
        dimension = unit(channel.unit).dimension
        quantities = {name: getattr(self.written, name) for name in ("above", "below")}
        fits = [self._has(dimension, value, name) for name, value in quantities.items() if value]
        if self.written.hysteresis is not None:
            fits.append(self._has(of_difference(dimension), self.written.hysteresis, "hysteresis"))
        fits += [
            self._has(dimension, quantity, "outside", index)
            for index, quantity in enumerate(self.written.outside or ())
        ]
        if self.written.rate is not None:
            fits.append(self._has(rate_of(dimension) or "", self.written.rate, "rate"))
        return all(fits)

    def _has(self, dimension: str, quantity: Quantity, key: str, *more: int) -> bool:
        problem = wrong_dimension(quantity, dimension, self.written.channel)
        if problem:
            self.complain(key, *problem, *more)
        return not problem
