"""Where lines come from: a serial port that a thread of its own listens at, or an example."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api import DeviceLostError, DeviceNotFoundError, DeviceRejectedError
from rigrunner_plugins.devices.extras import missing_package, reason_of
from rigrunner_plugins.devices.serial_ascii.line_buffer import Line, LineBuffer
from rigrunner_plugins.devices.text.numbers import excerpt

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Clock
    from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings

_LOOK_S = 0.05
"""How often the thread looks whether it is to end."""
_BLOCK_S = 0.1
"""How long lines are gathered while recording."""
_END_S = 1.0
"""How long the thread may take to end: it looks every _LOOK_S."""


class Lines(Protocol):
    """Where lines come from."""

    def send(self, text: str) -> None:
        """Send a text that is not answered by a line of its own."""
        ...

    def ask(self, text: str, is_answer: Callable[[str], bool], within_s: float) -> str:
        """Send a text and return the first line after it that is an answer."""
        ...

    def newest(self) -> str:
        """Return the newest line, which is not stale."""
        ...

    def record(self) -> None:
        """Keep every line from now on."""
        ...

    def recorded(self) -> list[Line]:
        """Return the lines since the last call, at least one."""
        ...

    def stop_recording(self) -> None:
        """Keep the newest line alone."""
        ...

    def close(self) -> None:
        """Give back what was opened."""
        ...


class PortLines:
    """The lines of an instrument behind a serial port."""

    def __init__(self, settings: SerialAsciiSettings, clock: Clock) -> None:
        self._settings = settings
        self._buffer = LineBuffer(settings, clock)
        self._ends = threading.Event()
        self._port = _open(settings)
        self.newest = self._buffer.newest
        self.record = self._buffer.record
        self.stop_recording = self._buffer.stop_recording
        self._thread = threading.Thread(
            target=self._listen, name=f"lines of {settings.port}", daemon=True
        )
        self._thread.start()

    def send(self, text: str) -> None:
        """Send a text; raise DeviceLostError."""
        ending = self._settings.write_termination
        ending = self._settings.termination if ending is None else ending
        try:
            self._port.write((text + ending).encode())
        except OSError as error:  # pyserial's SerialException is one
            raise DeviceLostError(f"'{text}' could not be sent: {error}") from error

    def ask(self, text: str, is_answer: Callable[[str], bool], within_s: float) -> str:
        """Send a text and return the first line that answers it; raise a DeviceError."""
        if self._settings.request and (unsolicited := self._buffer.unsolicited()):
            raise DeviceRejectedError(
                f"before '{text}' was sent, {excerpt(unsolicited)} arrived unrequested",
                hint="if the instrument sends lines by itself, leave out `request`",
            )
        return self._buffer.answer(lambda: self.send(text), is_answer, within_s)

    def recorded(self) -> list[Line]:
        """Return the lines since the last call, gathered for a tenth of a second."""
        self._ends.wait(_BLOCK_S)
        return self._buffer.recorded()

    def close(self) -> None:
        """End the thread and give the port back."""
        self._ends.set()
        self._thread.join(_END_S)
        with suppress(OSError):
            self._port.close()

    def _listen(self) -> None:
        while not self._ends.is_set():
            try:
                data = self._port.read(max(1, self._port.in_waiting))
            except (OSError, TypeError) as error:  # TypeError: closed under a read, by pyserial
                self._buffer.fail(error)
                return
            if data:
                self._buffer.feed(data)


class ExampleLines:
    """A simulated instrument: sends the example of the settings."""

    def __init__(self, settings: SerialAsciiSettings, clock: Clock) -> None:
        self._settings = settings
        self._clock = clock

    def send(self, text: str) -> None:
        """Do nothing: it is simulated."""

    def ask(self, text: str, is_answer: Callable[[str], bool], within_s: float) -> str:  # noqa: ARG002  (the Protocol's)
        """Return the example."""
        return self._settings.example

    def newest(self) -> str:
        """Return the example."""
        return self._settings.example

    def record(self) -> None:
        """Nothing has to be kept."""

    def recorded(self) -> list[Line]:
        """Return as many examples as the rate gives in a tenth of a second."""
        count = max(1, int((self._settings.rate or 1.0) * _BLOCK_S))
        lines = []
        for _ in range(count):
            self._clock.sleep(1 / (self._settings.rate or 1.0))
            lines.append(Line(self._settings.example, self._clock.monotonic_s()))
        return lines

    def stop_recording(self) -> None:
        """Nothing was kept."""

    def close(self) -> None:
        """Nothing was opened."""


def _open(settings: SerialAsciiSettings) -> Any:
    """Return the open port; raise DeviceNotFoundError, or MissingPackageError."""
    try:
        import serial  # noqa: PLC0415  (optional)
    except ImportError as error:
        raise missing_package("pyserial", "serial") from error
    line = settings.serial
    try:
        port = serial.Serial(
            settings.port,
            baudrate=line.baud,
            bytesize=line.data_bits,
            parity=line.parity[0].upper(),
            stopbits=line.stop_bits,
            xonxoff=line.flow_control == "xon_xoff",
            rtscts=line.flow_control == "rts_cts",
            timeout=_LOOK_S,
            write_timeout=settings.stale,
            exclusive=True,  # of two programs at one port each would get a part
        )
        port.reset_input_buffer()
    except (OSError, ValueError) as error:
        hint = "is it plugged in, and not in use by another program?"
        if "denied" in str(error).lower():
            hint = "on Linux, join the group of the port, often 'dialout'"
        raise DeviceNotFoundError(
            f"{settings.port} cannot be opened: {reason_of(error)}", hint=hint
        ) from error
    return port
