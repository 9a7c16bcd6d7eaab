"""An instrument that talks Modbus, as channels and drives."""

from __future__ import annotations

import itertools
import threading
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    Driver,
    Identity,
)
from rigrunner.api.cleanup import do_all
from rigrunner.api.driver import check_patience
from rigrunner_plugins.devices.declared import (
    channel_infos,
    drive_infos,
    reading_infos,
    refuse_other,
)
from rigrunner_plugins.devices.extras import missing_package
from rigrunner_plugins.devices.modbus.grouping import MOST_REGISTERS, Span, spans
from rigrunner_plugins.devices.modbus.places import address_text
from rigrunner_plugins.devices.modbus.settings import Tcp

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api import DeviceContext
    from rigrunner.api.readings import Reading
    from rigrunner_plugins.devices.modbus.line import Line
    from rigrunner_plugins.devices.modbus.places import Number, Place
    from rigrunner_plugins.devices.modbus.served.server import ModbusServer
    from rigrunner_plugins.devices.modbus.settings import ModbusSettings, Watchdog, Write


class Heartbeat:
    """Shows the instrument from `start` to `stop` that this program and the line are alive.

    It is no proof of more: it runs in a thread of its own. Where a beat fails the line is closed,
    with the reason.
    """

    def __init__(self, watchdog: Watchdog, line: Line) -> None:
        self._watchdog = watchdog
        self._line = line
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._beat, name="modbus watchdog", daemon=True)

    def start(self) -> None:
        """Begin, in a thread of its own."""
        self._thread.start()

    def stop(self) -> None:
        """End; return once the thread has ended."""
        self._ended.set()
        self._thread.join()

    def _beat(self) -> None:
        watchdog = self._watchdog
        beat = Span(watchdog.table, watchdog.address, 1, watchdog.unit_id)
        for value in itertools.cycle(watchdog.write or (None,)):
            try:
                if value is None:
                    self._line.read(beat)
                else:
                    self._line.write(watchdog, [value], multiple=False)
            except DeviceError as error:
                self._line.close(f"the watchdog failed: {error.message}")
                return
            if self._ended.wait(watchdog.every):
                return


_T = TypeVar("_T")
_BASIC_OBJECTS = range(3)
"""Maker, product and revision (Application Protocol Specification V1.1b3, clause 6.21)."""


class ModbusDevice(Driver):
    """Reads channels in as few requests as sensible, and writes set-points with their commands."""

    reconnects_after = (DeviceLostError,)  # each answer names its request

    def __init__(self, settings: ModbusSettings, context: DeviceContext) -> None:
        super().__init__(context, channel_infos(settings.channels), drive_infos(settings.drives))
        # Before each try a late serial answer is waited for as long again, after it a busy unit.
        check_patience(2 * settings.timeout * (settings.retries + 1), context)
        self._settings = settings
        self.readings = reading_infos(settings.readings)
        self._opened: Line | None = None
        self._heartbeat: Heartbeat | None = None
        self._server: ModbusServer | None = None
        self._moment_s = 0.0

    def open(self, timeout_s: float) -> Identity:
        """Connect, identify the instrument, and serve its watchdog from then on."""
        self.shut()
        self.exchange("connect", lambda: self._open_line(timeout_s))
        identity = self._identify()
        if self._settings.watchdog is not None:
            self.exchange("start the watchdog", self._start_watchdog)
        return identity

    def shut(self) -> None:
        """End the watchdog and close the connection."""
        if self._heartbeat is not None:
            self._heartbeat.stop()
            self._heartbeat = None
        if self._opened is not None:
            self._opened.close()
            self._opened = None
        if self._server is not None:
            self._server.stop()
            self._server = None

    def exchange(self, request: str, perform: Callable[[], _T]) -> _T:
        """Do one exchange; a simulator gets the present time."""
        if self._settings.simulated:
            self._moment_s = self.clock.monotonic_s()
        return super().exchange(request, perform)

    def get(self, channel: str) -> float:
        """Return the present value of a channel."""
        return self.get_all([channel])[channel]

    def get_all(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the present values; numbers in neighbouring registers come in one answer."""
        places = {name: self._settings.channels[name] for name in channels}
        numbers = self._read_numbers(list(places.values()))
        return {
            name: places[name].to_si(number) for name, number in zip(places, numbers, strict=True)
        }

    def get_reading(self, reading: str) -> Reading:
        """Return a text, whether a bit is set, or the numbers of an array."""
        settings = self._settings.readings[reading]
        if settings.text is not None:
            return self._text_at(settings, settings.text)
        if settings.values is not None:
            numbers = self._read_array(settings, settings.values)
            return settings.to_si([number * settings.scale + settings.offset for number in numbers])
        return bool(self._read_numbers([settings])[0])

    def put(self, drive: str, value: float) -> None:
        """Write a set-point: with the words that let it run, or, to be safe, that stop it."""
        settings = self._settings.drives[drive]

        def write() -> None:
            try:
                words = settings.encode(settings.from_si(value))
            except ValueError as error:
                raise DeviceRejectedError(f"set {drive}: {error}") from error
            self._write(settings, words, multiple=settings.multiple)

        if value == self._drives[drive].safe_value:
            # a stop that is refused must not keep the set-point up, nor the next stop from its turn
            do_all(*(partial(self._send_command, command) for command in settings.stop), write)
        else:
            # The set-point goes first: the words of `run` would start the motor for the one
            # before it.
            write()
            for command in settings.run:
                self._send_command(command)

    def actual(self, drive: str) -> float:
        """Return the actual value of a drive."""
        settings = self._settings.drives[drive]
        back = settings.read_back or settings
        return back.to_si(self._read_numbers([back])[0])

    def arrived(self, drive: str) -> bool:
        """Return whether a drive is there; raise DeviceRejectedError if a fault keeps it away."""
        if super().arrived(drive):
            return True
        if self._set_points.get(drive) != self._drives[drive].safe_value:  # to rest it may coast
            self._mapped("read the fault", self._check_fault)
        return False

    def _read_numbers(self, numbers: Sequence[Number]) -> list[float]:
        """Return the numbers as the registers have them."""
        words_by_span = {
            span: self._read_words(span)
            for span in spans(numbers, together=self._settings.group_reads)
        }
        values = []
        for number in numbers:
            span = next(span for span in words_by_span if span.holds(number))
            first = number.address - span.address
            values.append(number.decode(words_by_span[span][first : first + number.count]))
        return values

    def _read_array(self, first: Number, values: int) -> list[float]:
        """Return numbers that follow upon each other, in as few requests as the standard allows."""
        size, most = first.count, MOST_REGISTERS // first.count
        numbers: list[float] = []
        while len(numbers) < values:
            count = min(most, values - len(numbers))
            at = first.address + len(numbers) * size
            words = self._read_words(Span(first.table, at, count * size, first.unit_id))
            numbers += [first.decode(words[i : i + size]) for i in range(0, count * size, size)]
        return numbers

    def _read_words(self, span: Span) -> list[int]:
        """Return registers, or bits as 0 and 1."""
        request = (
            f"read {span.table} {address_text(span.address, span.count)}{_of_unit(span.unit_id)}"
        )
        words = self.exchange(request, lambda: self._line.read(span))
        if len(words) != span.count:  # of a played-back exchange
            raise DeviceRejectedError(f"{request}: {len(words)} came, expected {span.count}")
        return words

    def _text_at(self, number: Number, registers: int) -> str:
        """Return the text in a number of registers."""
        words = self._read_words(Span(number.table, number.address, registers, number.unit_id))
        raw = b"".join(word.to_bytes(2, number.byte_order) for word in words)
        return raw.decode("ascii", "replace").strip("\0 ")

    def _identify(self) -> Identity:
        """Return who answers; raise DeviceNotFoundError if it is another one than expected.

        Where the station says nothing of its identity, a first number is read: a serial port opens
        also with nothing behind it.
        """
        settings, identification = self._settings, self._settings.identification
        texts = dict.fromkeys(("maker", "model", "serial", "firmware"), "")
        if identification.standard:
            texts["maker"], texts["model"], texts["firmware"] = self._read_identification()
        parts = {
            "model": identification.model,
            "serial": identification.serial,
            "firmware": identification.firmware,
        }
        for name, part in parts.items():
            if part is not None and part.text is not None:
                texts[name] = self._text_at(part, part.text)
            elif part is not None:
                texts[name] = f"{self._read_numbers([part])[0]:.10g}"
        if not any(texts.values()):
            numbers: tuple[Number, ...] = (
                *settings.channels.values(),
                *(drive.read_back or drive for drive in settings.drives.values()),
                *settings.readings.values(),
            )
            self._read_numbers(numbers[:1])
        refuse_other(settings.where, texts, identification.expect)
        return Identity(
            maker=texts["maker"] or "unknown",
            model=texts["model"] or f"Modbus {settings.where}",
            serial=texts["serial"] or "not told",
            firmware=texts["firmware"],
            simulated=settings.simulated,
        )

    def _read_identification(self) -> list[str]:
        """Return maker, product and revision by Read Device Identification."""

        def ask() -> list[str]:
            objects = self._line.identification()
            return [objects.get(number, "") for number in _BASIC_OBJECTS]

        objects = self.exchange("read device identification", ask)
        if len(objects) != len(_BASIC_OBJECTS) or not any(objects):
            raise DeviceNotFoundError(f"{self._settings.where} does not identify itself")
        return objects

    @property
    def _line(self) -> Line:
        if self._opened is None:
            raise DeviceLostError("not connected")
        return self._opened

    def _open_line(self, timeout_s: float) -> None:
        try:
            from rigrunner_plugins.devices.modbus.line import Line  # noqa: PLC0415  (pymodbus)

            settings = self._settings
            if settings.simulator is not None:
                from rigrunner_plugins.devices.modbus.served.server import serve  # noqa: PLC0415  (pymodbus)

                self._server = serve(settings.simulator, settings.unit_id, lambda: self._moment_s)
                tcp = Tcp(host="127.0.0.1", port=self._server.port)
                settings = settings.model_copy(update={"tcp": tcp})
            self._opened = Line(settings)
            self._opened.open(timeout_s)
        except ModuleNotFoundError as error:
            raise missing_package((error.name or "pymodbus").partition(".")[0], "modbus") from error

    def _start_watchdog(self) -> None:
        if self._settings.watchdog is not None:
            self._heartbeat = Heartbeat(self._settings.watchdog, self._line)
            self._heartbeat.start()

    def _check_fault(self) -> None:
        fault = self._settings.fault
        if fault is None:
            return
        code = self._read_numbers([fault])[0]
        if code != fault.ok:
            meaning = fault.codes.get(f"{code:.0f}", "see its manual")
            raise DeviceRejectedError(
                f"{self._settings.where} is in fault {code:.0f}: {meaning}",
                hint="fix the cause and reset it at the instrument",
            )

    def _send_command(self, command: Write) -> None:
        self._write(command, [command.value])
        self.clock.sleep(command.wait)

    def _write(self, place: Place, words: Sequence[int], *, multiple: bool = False) -> None:
        request = f"{' '.join(map(str, words))} to {place.table} {place.address}"
        self.exchange(
            f"write {request}{_of_unit(place.unit_id)}",
            lambda: self._line.write(place, words, multiple=multiple),
        )


def _of_unit(unit_id: int | None) -> str:
    return "" if unit_id is None else f" of unit {unit_id}"
