"""What every composite can do: connect, make safe and close all its parts as one."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api import DeviceError, DeviceLostError, DeviceRejectedError, Identity
from rigrunner.api.cleanup import add_beside, error_text, errors_of, raise_first

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rigrunner.api import ChannelInfo, DeviceContext, DriveInfo
    from rigrunner.api.calling import MovingCall
    from rigrunner_plugins.devices.composite.part import Part
    from rigrunner_plugins.devices.composite.routes import ChannelRoute, DriveRoute, ReadingRoute
    from rigrunner_plugins.devices.composite.settings import ClockSettings

POLL_S = 0.05
"""How often a drive that is on its way is read back."""


class Composite:
    """What every device can do."""

    non_blocking = True
    """Each call of a part that could hang has its own time limit."""

    def __init__(  # noqa: PLR0917  (what a composite is made of)
        self,
        context: DeviceContext,
        parts: Mapping[str, Part],
        channels: Mapping[str, ChannelRoute],
        drives: Mapping[str, DriveRoute],
        readings: Mapping[str, ReadingRoute],
        clocks: ClockSettings,
        reference: str,
    ) -> None:
        self.clock = context.clock
        self.patience = context.patience
        self.clocks = clocks
        self.reference = reference
        self.parts = parts
        self.channel_routes = channels
        self.drive_routes = drives
        self.reading_routes = readings
        self.set_points: dict[str, float] = {}
        self.paused_set_points: Mapping[str, float] = {}
        self._connected = False

    @property
    def channels(self) -> Sequence[ChannelInfo]:
        """The channels that the station names."""
        return tuple(route.info for route in self.channel_routes.values())

    @property
    def drives(self) -> Sequence[DriveInfo]:
        """The drives that the station names, in its order."""
        return tuple(route.info for route in self.drive_routes.values())

    @property
    def reads_back_while_streaming(self) -> bool:
        """Whether drives are read back from parts that do not stream, or allow it meanwhile.

        Not where several parts stream: their clocks are compared by when samples arrive, and each
        read-back would delay that.
        """
        streaming = {route.part for route in self.channel_routes.values() if route.info.streams}
        if len(streaming) > 1:
            return False
        routes = [route.read_back or route for route in self.drive_routes.values()]
        return all(
            getattr(self.parts[route.part].device, "reads_back_while_streaming", False)
            for route in routes
            if route.part in streaming
        )

    def connect(self, timeout_s: float) -> Identity:
        """Connect all parts; if one fails, make safe and close those that are connected."""
        identities: dict[str, Identity] = {}
        try:
            for name, part in self.parts.items():
                identities[name] = part.connect(timeout_s)
        except BaseException as error:
            # Nothing stays energised or open; what fails in that is added to the error.
            safe_calls = [part.make_safe for part in self._safe_order() if part.name in identities]
            errors = _try_all([*safe_calls, *(part.close for part in self.parts.values())])
            if errors and isinstance(error, DeviceError):
                error.message = "; then ".join([error.message, *map(str, errors)])
            else:
                for failure in errors:
                    add_beside(error, str(failure))
            raise
        self._connected = True
        return Identity(
            "Rigrunner",
            f"composite of {', '.join(identities)}",
            "",
            simulated=any(identity.simulated for identity in identities.values()),
            parts=identities,
        )

    def make_safe(self) -> Mapping[str, float]:
        """Make all parts safe, whatever fails, and return the actual values of the drives.

        Parts come in the order in which the drives name them. A set of a part that was given up is
        waited for then, and the part made safe behind it. If one fails, the error states which and
        why, and the actual values of the other drives.
        """
        given_up = {part: late for part in self._safe_order() if (late := part.late)}
        self.set_points.clear()
        self.paused_set_points = {}  # a pause is over: nothing may move again by `resume`
        read_back: dict[str, Mapping[str, float]] = {}
        actual_values: dict[str, float] = {}

        def make_safe(part: Part) -> None:
            read_back[part.name] = part.make_safe()

        def read_actual(route: DriveRoute) -> None:
            drive = route.info.name
            if route.part not in read_back:
                with suppress(Exception):  # the failure is reported already
                    actual_values[drive] = self.actual_value(route)
            elif route.read_back is None:
                actual_values[drive] = read_back[route.part][route.name]
            else:
                actual_values[drive] = self._actual_at_rest(route)

        def make_safe_behind(part: Part, late: MovingCall) -> None:
            read_back[part.name] = part.make_safe_behind(late)

        errors = _try_all([partial(make_safe, part) for part in self._safe_order()])
        errors += _try_all([partial(make_safe_behind, *call) for call in given_up.items()])
        errors += _try_all([partial(read_actual, route) for route in self.drive_routes.values()])
        if errors:
            raise _combined_error(errors, actual_values, self.drives)
        return actual_values

    def close(self) -> None:
        """Close all parts; the first error is raised after all were tried."""
        self._connected = False
        errors = _try_all([part.close for part in self.parts.values()])
        if errors:
            raise errors[0]

    def _safe_order(self) -> list[Part]:
        names = [*(route.part for route in self.drive_routes.values()), *self.parts]
        return [self.parts[name] for name in dict.fromkeys(names)]

    def _actual_at_rest(self, route: DriveRoute) -> float:
        """Return the actual value of a drive once it is safe, or has had its time."""
        info = route.info
        until_s = self.clock.monotonic_s() + info.longest_s
        while True:
            value = self.actual_value(route)
            is_near = abs(value - info.safe_value) <= info.allowed_deviation
            if is_near or self.clock.monotonic_s() >= until_s:
                return value
            self.clock.sleep(POLL_S)

    def actual_value(self, route: DriveRoute) -> float:
        """Return the actual value of a drive, by the channel that measures it if there is one."""
        if route.read_back is None:
            return self.parts[route.part].read_back(route.name)
        channel = route.read_back
        return float(self.parts[channel.part].read([channel.name])[channel.name])

    def need_connection(self) -> None:
        """Raise DeviceLostError unless all parts are connected."""
        if not self._connected:
            raise DeviceLostError("not connected")


def _try_all(calls: Iterable[Callable[[], object]]) -> list[DeviceError]:
    """Make all calls, whatever fails, and return what did; Ctrl-C is raised after the last one."""
    errors = errors_of(*calls)
    if any(isinstance(error, KeyboardInterrupt) for error in errors):
        raise_first(errors)
    return [
        error if isinstance(error, DeviceError) else DeviceRejectedError(error_text(error))
        for error in errors
    ]


def _combined_error(
    errors: Sequence[DeviceError], actual_values: Mapping[str, float], drives: Sequence[DriveInfo]
) -> DeviceError:
    """Return one error, of the first's kind, with all failures and the known actual values."""
    units = {info.name: info.unit for info in drives}
    texts = [f"{name} at {value:g} {units[name]}" for name, value in actual_values.items()]
    messages = dict.fromkeys(error.message for error in errors)
    read_back_text = f"; read back were {', '.join(texts)}" if texts else ""
    return type(errors[0])("; ".join(messages) + read_back_text, hint=errors[0].hint)
