"""What a composite can do if its parts can: read, set, stream, pause, and what simulators know."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api import DeviceRejectedError
from rigrunner.api.devices import CountsStreams, KnowsTruth
from rigrunner.api.driver import wait_until_arrived
from rigrunner.api.quantity import legible
from rigrunner_plugins.devices.channels import find
from rigrunner_plugins.devices.composite.base import POLL_S, Composite
from rigrunner_plugins.devices.composite.clocks.aligned import AlignedStream, StreamPlan

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Mapping, Sequence

    from rigrunner.api import Block, StopToken
    from rigrunner.api.devices import ReadingInfo
    from rigrunner.api.readings import Reading
    from rigrunner_plugins.devices.composite.routes import ChannelRoute


class Reads(Composite):
    """Gives single values of its parts' channels."""

    def read(self, channels: Sequence[str]) -> Mapping[str, float]:
        """Return the present value of each channel; each part is read once."""
        self.need_connection()
        routes = [find("channel", name, self.channel_routes) for name in channels]
        values = {
            part: self.parts[part].read([route.name for route in routes if route.part == part])
            for part in dict.fromkeys(route.part for route in routes)
        }
        return {route.info.name: float(values[route.part][route.name]) for route in routes}


class Observes(Composite):
    """Gives the readings of its parts that are not numbers."""

    @property
    def readings(self) -> Sequence[ReadingInfo]:
        """The readings that the station names."""
        return tuple(route.info for route in self.reading_routes.values())

    def observe(self, readings: Sequence[str]) -> Mapping[str, Reading]:
        """Return the present value of each reading; each part is read once."""
        self.need_connection()
        routes = [find("reading", name, self.reading_routes) for name in readings]
        observed = {
            part: self.parts[part].observe([route.name for route in routes if route.part == part])
            for part in dict.fromkeys(route.part for route in routes)
        }
        return {route.info.name: observed[route.part][route.name] for route in routes}


class Sets(Composite):
    """Sets its parts' drives; where one does not take its time, `begin` waits for it."""

    def begin(self, drive: str, value: float) -> None:
        """Give the drive a new set-point within its limits."""
        route = find("drive", drive, self.drive_routes)
        self.need_connection()
        info = route.info
        if not info.minimum <= value <= info.maximum:
            raise DeviceRejectedError(
                f"{drive}: {legible(value, info.unit)} is out of range ({info.range_text})"
            )
        self.parts[route.part].begin(route.name, value)
        self.set_points[drive] = value

    def arrived(self, drive: str) -> bool:
        """Return whether it is reached, by the part that sets it and the one that measures it."""
        route = find("drive", drive, self.drive_routes)
        if drive not in self.set_points or not self.parts[route.part].arrived(route.name):
            return False
        deviation = abs(self.actual_value(route) - self.set_points[drive])
        return deviation <= route.info.allowed_deviation

    def set(self, drive: str, value: float) -> None:
        """Give the drive a new set-point and wait until it is reached."""
        self.begin(drive, value)
        wait_until_arrived(self, self.drive_routes[drive].info, value, self.clock, POLL_S)

    def read_back(self, drive: str) -> float:
        """Return the actual value of the drive."""
        route = find("drive", drive, self.drive_routes)
        self.need_connection()
        return self.actual_value(route)


class Streams(Composite):
    """Records channels of one part, or of several on the time base of the reference."""

    _aligned: AlignedStream | None = None
    _streamed: Sequence[ChannelRoute] = ()

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second and channel of the reference."""
        return float(self.parts[self.reference].device.sample_rate_hz)

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield the blocks of the parts that have these channels."""
        self.need_connection()
        routes = [find("channel", name, self.channel_routes) for name in channels]
        read_only = [route.info.name for route in routes if not route.info.streams]
        if read_only:
            raise DeviceRejectedError(
                f"{', '.join(read_only)} cannot be recorded: read as single values"
            )
        parts = list(dict.fromkeys(route.part for route in routes))
        self._aligned, self._streamed = None, routes
        # A slower part alone is aligned as well: a role has one sample rate, that of the reference.
        if len(parts) == 1 and self.parts[parts[0]].device.sample_rate_hz == self.sample_rate_hz:
            names = [route.name for route in routes]
            return _rename_channels(self.parts[parts[0]].stream(names, duration_s, stop), routes)
        plan = StreamPlan(routes, self.parts, self.clocks, self.reference, self.patience.answer_s)
        self._aligned = AlignedStream(plan, duration_s, stop, self.clock)
        return self._aligned.blocks()

    def stream_conditions(self) -> Mapping[str, tuple[float, str]]:
        """Return what the parts report of the last stream, and how their clocks were aligned.

        What a part says of a channel stands under the channel's name in the role.
        """
        conditions: dict[str, tuple[float, str]] = {}
        for route in self._streamed:
            part = self.parts[route.part]
            names = [info.name for info in part.device.channels]
            for name, value in part.stream_conditions().items():
                # Of the longest name of a channel that it begins with.
                channel = max(
                    (each for each in names if name.startswith(f"{each}_")), key=len, default=""
                )
                if channel == route.name:
                    conditions[route.info.name + name.removeprefix(channel)] = value
        return conditions if self._aligned is None else {**conditions, **self._aligned.conditions()}


class Pauses(Sets):
    """Stands still by the drives that set the frequency of a cyclic motion."""

    def pause(self) -> None:
        """Bring what moves in cycles to its safe value; all else stays as it is."""
        self.need_connection()
        self.paused_set_points = {
            name: self.set_points.get(name, route.info.safe_value)
            for name, route in self.drive_routes.items()
            if route.info.sets_cycle_frequency
        }
        for name in self.paused_set_points:
            self.set(name, self.drive_routes[name].info.safe_value)

    def resume(self) -> None:
        """Let it move again as before."""
        self.need_connection()
        for name, value in self.paused_set_points.items():
            self.set(name, value)


class CountsPartsStreams(Composite):
    """Has simulators among its parts that count streams."""

    def continue_after(self, streams: Sequence[Mapping[str, float]]) -> None:
        """Pass the earlier streams to each part that counts them, by its own drives' names."""
        for name, part in self.parts.items():
            device = part.device
            if not isinstance(device, CountsStreams):
                continue
            names = {
                drive: route.name
                for drive, route in self.drive_routes.items()
                if route.part == name
            }
            part_streams = [
                {names[drive]: value for drive, value in stream.items() if drive in names}
                for stream in streams
            ]
            part.call("continue a run", partial(device.continue_after, part_streams))


class KnowsPartsTruth(Composite):
    """Has simulators among its parts that know the truth."""

    def truth(self) -> Mapping[str, float]:
        """Return what the simulators among the parts know."""
        values: dict[str, float] = {}
        for part in self.parts.values():
            if isinstance(part.device, KnowsTruth):
                values |= part.call("tell the truth", part.device.truth)
        return values


def _rename_channels(blocks: Generator[Block], routes: Sequence[ChannelRoute]) -> Generator[Block]:
    with closing(blocks):
        for block in blocks:
            channels = {route.info.name: block.channels[route.name] for route in routes}
            yield replace(block, channels=channels)
