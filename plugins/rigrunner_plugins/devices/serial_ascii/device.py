"""An instrument that sends lines, and can be read."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    Driver,
    Identity,
)
from rigrunner.api.cleanup import do_all
from rigrunner_plugins.devices.channels import find
from rigrunner_plugins.devices.declared import channel_infos, reading_infos
from rigrunner_plugins.devices.serial_ascii.port import ExampleLines, PortLines
from rigrunner_plugins.devices.text.patterns import fits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import DeviceContext
    from rigrunner.api.readings import Reading
    from rigrunner_plugins.devices.serial_ascii.port import Lines
    from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings


class SerialAscii(Driver):
    """An instrument whose every line holds all of its channels.

    After a failure the port is given back, and opened again for the next line.
    """

    def __init__(self, settings: SerialAsciiSettings, context: DeviceContext) -> None:
        super().__init__(context, channel_infos(settings.channels))
        self._settings = settings
        self.readings = reading_infos(settings.readings)
        self._lines: Lines | None = None

    def open(self, timeout_s: float) -> Identity:  # noqa: ARG002  (nothing here takes longer than `stale`)
        """Open the port, identify, and see that lines come that are understood."""
        self.exchange(f"open {self._settings.port}", self._open)
        identity = self._identify()
        if self._settings.start:
            self.exchange(f"send {self._settings.start}", self._start)
        self._values()
        return identity

    def shut(self) -> None:
        """Tell the instrument to stop, and give the port back."""
        lines, self._lines = self._lines, None
        if lines is not None:
            stop = self._settings.stop
            do_all(*([lambda: lines.send(stop)] if stop else []), lines.close)

    def get(self, channel: str) -> float:
        """Return the newest value of a channel."""
        return self._values()[channel]

    def read(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the value of each channel, all out of one line."""
        self.check_channels(channels)
        values = self._values()
        return {name: values[name] for name in channels}

    def get_reading(self, reading: str) -> Reading:
        """Return a reading of the newest line."""
        return self.observe([reading])[reading]

    def observe(self, readings: Sequence[str]) -> dict[str, Reading]:
        """Return each reading, all out of one line."""
        self._need_connection()
        values = self._settings.readings_in(self._line())
        return {name: find("reading", name, values) for name in readings}

    def _line(self) -> str:
        request = self._settings.request
        return self.exchange(f"request {request}" if request else "newest line", self._read_newest)

    def _values(self) -> dict[str, float]:
        return self._settings.values_in(self._line())

    def _read_newest(self) -> str:
        lines, settings = self._open_lines(), self._settings
        try:
            if settings.request:
                return lines.ask(
                    settings.request, lambda line: not settings.is_ignored(line), settings.stale
                )
            return lines.newest()
        except (DeviceLostError, DeviceTimeoutError):
            self._drop()
            raise

    def _identify(self) -> Identity:
        identification, port = self._settings.identification, self._settings.port
        if identification is None or self._settings.simulated:
            simulated = self._settings.simulated
            return Identity("unidentified", f"instrument at {port}", "", simulated=simulated)

        def ask() -> str:
            lines, stale_s = self._open_lines(), self._settings.stale
            try:
                return lines.ask(
                    identification.query, partial(fits, identification.expect), stale_s
                ).strip()
            except DeviceTimeoutError as error:
                raise DeviceNotFoundError(
                    f"no instrument that matches '{identification.expect}' answers"
                    f" '{identification.query}': {error.message}",
                    hint="is it the right instrument? in `expect`, .* matches anything",
                ) from error

        answer = self.exchange(f"query {identification.query}", ask)
        return Identity("unknown", answer, "")

    def _open(self) -> None:
        self._drop()
        make = ExampleLines if self._settings.simulated else PortLines
        self._lines = make(self._settings, self.clock)

    def _start(self) -> None:
        self._open_lines().send(self._settings.start)

    def _open_lines(self) -> Lines:
        if self._lines is None:
            try:
                self._open()
                if self._settings.start:
                    self._start()
            except DeviceNotFoundError as error:
                raise DeviceLostError(error.message, hint=error.hint) from error
        assert self._lines is not None  # noqa: S101  (opened above)
        return self._lines

    def _drop(self) -> None:
        lines, self._lines = self._lines, None
        if lines is not None:
            lines.close()
