"""Drivers of instruments that are asked by a line of text and answer with one.

Many do, over a TCP socket or a serial port, in SCPI or in their maker's own words. A driver says
what is asked and what the answers mean; what is the same for all of them is here. A simulator of
the instrument answers the same lines, so that all of a driver is tried without its instrument.
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
)
from rigrunner.api.line_link import LineLink
from rigrunner.api.ports import SerialPort, TcpPort
from rigrunner.api.settings import PositiveDuration, SimulableSettings

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import DeviceContext

_HOST_AND_PORT = re.compile(r"(?P<host>[^\s:]+|\[[0-9A-Fa-f:.]+\]):(?P<port>\d{1,5})")
_SERIAL_PORT = re.compile(r"/dev/\S+|COM\d+")


class LineSettings(SimulableSettings):
    """Where an instrument is found that talks in lines of text."""

    address: str = ""
    """host:port, or a serial port such as /dev/ttyUSB0 or COM3; not needed of a simulated one."""
    baud: Annotated[int, Field(ge=50, le=4_000_000)] = 9600
    """Bits per second of a serial port."""
    timeout: PositiveDuration = 2.0
    """How long the answer to a line is waited for; the station's patience must be longer."""

    @model_validator(mode="after")
    def _can_be_found(self) -> Self:
        if not self.address and self.simulated:
            return self
        found = _HOST_AND_PORT.fullmatch(self.address)
        if self.is_serial or (found and 0 < int(found["port"]) < 65536):  # noqa: PLR2004  (16 bits)
            return self
        got = f"'{self.address}'" if self.address else "nothing"
        raise ValueError(
            f"address: got {got}, allowed is host:port, a serial port, or 'simulated: yes'"
        )

    @property
    def is_serial(self) -> bool:
        """Whether the address is that of a serial port."""
        return _SERIAL_PORT.fullmatch(self.address) is not None


class Answering(Protocol):
    """A simulated instrument."""

    def answer(self, request: str) -> str:
        """Return the line that answers a line; an empty one where the instrument keeps silent."""
        ...


class LineDriver(Driver):
    """A Driver that asks its instrument by lines of text; give it `get` and, with drives, `put`.

    Every exchange goes over the wire: its DeviceRecord is `wired`. A ValueError, such as that of
    `float` for an answer that is no number, is a DeviceRejectedError.
    """

    simulator: ClassVar[type[Answering]]
    """Makes what answers where the settings say `simulated: yes`."""
    terminator: ClassVar[str] = "\n"
    """What ends a line, both ways."""
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
        self.settings = settings
        self._link: _Link | None = None

    def open(self, timeout_s: float) -> Identity:
        """Open the connection and say who answers."""
        address = "the simulator" if self.settings.simulated else self.settings.address
        self.exchange(f"open {address}", lambda: self._open(timeout_s))
        return replace(self.identify(), simulated=self.settings.simulated)

    def identify(self) -> Identity:
        """Say who answers; by itself what '*IDN?' is answered with (IEEE 488.2, 10.14).

        Raise a DeviceNotFoundError where that is not the instrument that it should be.
        """
        answer = self.ask("*IDN?")
        fields = [field.strip() for field in answer.split(",")]
        if len(fields) != 4:  # noqa: PLR2004  (maker, model, serial number, firmware)
            raise DeviceNotFoundError(
                f"*IDN? was answered by '{answer}', needed is 'maker,model,serial,firmware'",
                hint="is it the right instrument at this address?",
            )
        maker, model, serial, firmware = fields
        return Identity(maker, model, serial, firmware)

    def ask(self, request: str) -> str:
        """Return the line that answers a line."""
        return self.exchange(f"ask {request}", lambda: self._linked().ask(request))

    def tell(self, request: str) -> None:
        """Send a line that is not answered."""
        self.exchange(f"tell {request}", lambda: self._linked().tell(request))

    def shut(self) -> None:
        """Give the connection back."""
        link, self._link = self._link, None
        if link is not None:
            link.close()

    def _open(self, timeout_s: float) -> None:
        self.shut()
        if self.settings.simulated:
            self._link = _Simulated(self.simulator())
        else:
            self._link = self._over(timeout_s)

    def _over(self, timeout_s: float) -> LineLink:
        settings, address = self.settings, self.settings.address
        serial = settings.is_serial
        port = SerialPort(address, settings.baud) if serial else TcpPort(address, timeout_s)
        return LineLink(address, port, self.terminator, settings.timeout)

    def _linked(self) -> _Link:
        if self._link is None:
            raise DeviceLostError("not connected")
        return self._link


class _Link(Protocol):
    """Carries lines to an instrument and back."""

    def ask(self, request: str) -> str: ...

    def tell(self, request: str) -> None: ...

    def close(self) -> None: ...


class _Simulated:
    """A simulated instrument, as silent as the real one where it is not asked for an answer."""

    def __init__(self, instrument: Answering) -> None:
        self._instrument = instrument

    def ask(self, request: str) -> str:
        answer = self._instrument.answer(request)
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
