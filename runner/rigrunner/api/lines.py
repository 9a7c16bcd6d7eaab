"""Drivers of instruments that communicate in lines of text.

Many do, over a TCP socket or a serial port, in SCPI or in a protocol of their own. A driver states
requests and meaning of the answers; this module has the common part. A simulator of the instrument
answers the same lines, so that all of a driver can be tested without the instrument.
"""

from __future__ import annotations

import re
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Annotated, ClassVar, Protocol, Self

from pydantic import Field, model_validator

from rigrunner.api.devices import Identity
from rigrunner.api.driver import Driver, check_patience
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    MissingPackageError,
    PluginError,
)
from rigrunner.api.line_link import LineLink
from rigrunner.api.ports import SerialPort, TcpPort
from rigrunner.api.settings import PositiveDuration, SimulableSettings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.devices import DeviceContext

_HOST_AND_PORT = re.compile(r"(?P<host>[^\s:]+|\[[0-9A-Fa-f:.]+\]):(?P<port>\d{1,5})")
_SERIAL_PORT = re.compile(r"/dev/\S+|COM\d+")


class LineSettings(SimulableSettings):
    """The address of an instrument that communicates in lines of text."""

    address: str = ""
    """host:port, or a serial port such as /dev/ttyUSB0 or COM3; not needed if simulated."""
    baud: Annotated[int, Field(ge=50, le=4_000_000)] = 9600
    """Bits per second of a serial port."""
    timeout: PositiveDuration = 2.0
    """Time-out of an answer; the time limit of the station must be longer."""

    @model_validator(mode="after")
    def _address_is_valid(self) -> Self:
        if not self.address and self.simulated:
            return self
        match = _HOST_AND_PORT.fullmatch(self.address)
        if self.is_serial or (match and 0 < int(match["port"]) < 65536):  # noqa: PLR2004  (16 bits)
            return self
        address = f"'{self.address}'" if self.address else "nothing"
        raise ValueError(
            f"address: got {address}, expected host:port, a serial port, or 'simulated: yes'"
        )

    def physical_addresses(self) -> Sequence[str]:
        """Return the address of the instrument, which one run at a time may use."""
        return (f"{'serial' if self.is_serial else 'tcp'}:{self.address}",) if self.address else ()

    @property
    def is_serial(self) -> bool:
        """Whether the address is a serial port."""
        return _SERIAL_PORT.fullmatch(self.address) is not None


class Answering(Protocol):
    """A simulated instrument."""

    def answer(self, request: str) -> str:
        """Return the answer to a line; empty if the instrument sends none."""
        ...


class LineDriver(Driver):
    """A Driver for lines of text; implement `get` and, with drives, `put`.

    Every exchange goes over the wire: the DeviceRecord is `wired`. A ValueError, such as that of
    `float` for an answer that is not a number, becomes a DeviceRejectedError.
    """

    simulator: ClassVar[type[Answering]]
    """Makes the simulator for `simulated: yes`."""
    reconnects_after: ClassVar[tuple[type[DeviceError], ...]] = (DeviceError,)
    """After any error: an answer does not state its request, and may belong to an earlier one."""
    terminator: ClassVar[str] = "\n"
    """End of a line, in both directions."""
    errors: ClassVar[Mapping[type[Exception], type[DeviceError]]] = {
        ValueError: DeviceRejectedError
    }

    def __init__(self, settings: LineSettings, context: DeviceContext) -> None:
        super().__init__(context)
        check_patience(settings.timeout, context)
        if settings.is_serial and find_spec("serial") is None:
            raise MissingPackageError(
                "a serial port needs the package pyserial", hint="pip install 'rigrunner[serial]'"
            )
        if settings.simulated:
            _need_simulator(type(self))
        self.settings = settings
        self._link: _Link | None = None
        self._instrument: Answering | None = None
        """The simulator, which keeps its state when reconnected."""

    def open(self, timeout_s: float) -> Identity:
        """Open the connection and identify the instrument."""
        address = "the simulator" if self.settings.simulated else self.settings.address
        self.exchange(f"open {address}", lambda: self._open(timeout_s))
        identity = self.identify()
        if not isinstance(identity, Identity):
            raise PluginError(
                f"`identify` of {type(self).__name__} gave {identity!r}, expected an Identity",
                hint="return Identity(maker, model, serial, firmware) of rigrunner.api.devices",
            )
        return replace(identity, simulated=self.settings.simulated)

    def identify(self) -> Identity:
        """Identify the instrument; by default by the answer to '*IDN?' (IEEE 488.2, 10.14).

        Raise a DeviceNotFoundError if it is not the expected instrument.
        """
        answer = self.ask("*IDN?")
        fields = [field.strip() for field in answer.split(",")]
        if len(fields) != 4:  # noqa: PLR2004  (maker, model, serial number, firmware)
            raise DeviceNotFoundError(
                f"*IDN? was answered by '{answer}', expected 'maker,model,serial,firmware'",
                hint="is it the right instrument at this address?",
            )
        maker, model, serial, firmware = fields
        return Identity(maker, model, serial, firmware)

    def ask(self, request: str) -> str:
        """Send a line and return the answer."""
        return self.exchange(f"ask {request}", lambda: self._linked().ask(request))

    def tell(self, request: str) -> None:
        """Send a line without an answer."""
        self.exchange(f"tell {request}", lambda: self._linked().tell(request))

    def shut(self) -> None:
        """Close the connection."""
        link, self._link = self._link, None
        if link is not None:
            link.close()

    def _open(self, timeout_s: float) -> None:
        self.shut()
        if self.settings.simulated:
            self._instrument = self._instrument or self.simulator()
            self._link = _Simulated(self._instrument)
        else:
            settings, serial = self.settings, self.settings.is_serial
            port = (
                SerialPort(settings.address, settings.baud)
                if serial
                else TcpPort(settings.address, timeout_s)
            )
            self._link = link = LineLink(settings.address, port, self.terminator, settings.timeout)
            if serial and self.is_reconnecting:
                # It waits up to three times as long, within the patience of the station.
                link.wait_for_silence(min(settings.timeout, self._patience.answer_s / 4))

    def _linked(self) -> _Link:
        if self._link is None:
            raise DeviceLostError("not connected")
        return self._link


def _need_simulator(kind: type[LineDriver]) -> None:
    """Raise PluginError for a driver without a simulator."""
    simulator = getattr(kind, "simulator", None)
    if simulator is None:
        problem = f"{kind.__name__} has no simulator, and its settings say 'simulated: yes'"
    elif not callable(getattr(simulator, "answer", None)):
        name = getattr(simulator, "__name__", simulator)
        problem = f"{name}, the simulator of {kind.__name__}, has no method `answer`"
    else:
        return
    raise PluginError(
        problem,
        hint="write `simulator = ...` into the class: a class with `answer(self, request) -> str`",
    )


class _Link(Protocol):
    """Exchanges lines with an instrument."""

    def ask(self, request: str) -> str: ...

    def tell(self, request: str) -> None: ...

    def close(self) -> None: ...


class _Simulated:
    """A simulated instrument, which sends nothing unless asked."""

    def __init__(self, instrument: Answering) -> None:
        self._instrument = instrument

    def ask(self, request: str) -> str:
        answer = self._instrument.answer(request)
        if not isinstance(answer, str):
            kind = type(self._instrument).__name__
            raise PluginError(
                f"`answer` of {kind} gave {answer!r} to '{request}', expected a str",
                hint="is there a `return`? return '' where the instrument does not answer",
            )
        if not answer:
            raise DeviceTimeoutError(f"'{request}' was not answered by the simulator")
        return answer

    def tell(self, request: str) -> None:
        answer = self._instrument.answer(request)
        if answer:
            raise DeviceRejectedError(
                f"'{request}' was answered by '{answer}', where no answer is expected"
            )

    def close(self) -> None:
        pass
