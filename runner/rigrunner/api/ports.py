"""Ports for lines of text: a TCP socket, or a serial port (pyserial)."""

from __future__ import annotations

import select
import socket
import time
from typing import Any

from rigrunner.api.errors import DeviceNotFoundError, DeviceTimeoutError

_AT_ONCE = 65536
_LOOK_S = 0.005
"""Polling interval of a serial port, about the time of a few characters."""


class TcpPort:
    """A TCP connection to `host:port`."""

    def __init__(self, address: str, connect_s: float) -> None:
        host, _, port = address.rpartition(":")
        try:
            self._socket = socket.create_connection((host.strip("[]"), int(port)), connect_s)
        except TimeoutError as error:
            raise DeviceTimeoutError(
                f"{address} did not accept the connection within {connect_s:g} s",
                hint="is it switched on, and on this network?",
            ) from error
        except OSError as error:
            raise DeviceNotFoundError(
                f"{address} cannot be reached: {error.strerror or error}",
                hint="is it switched on, is the address correct, is it in use by another program?",
            ) from error

    def ready(self, within_s: float) -> bool:
        """Return whether there is data, or the end of the connection."""
        return bool(select.select([self._socket], [], [], within_s)[0])

    def receive(self) -> bytes:
        """Return the received data."""
        return self._socket.recv(_AT_ONCE)

    def transmit(self, data: bytes, within_s: float) -> None:
        """Send all of the data."""
        self._socket.settimeout(within_s)
        self._socket.sendall(data)

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()


class SerialPort:
    """A serial port of this machine: 8 data bits, no parity, one stop bit; requires pyserial."""

    def __init__(self, name: str, baud: int) -> None:
        import serial  # noqa: PLC0415  (an extra)

        try:
            self._port: Any = serial.Serial(name, baud, timeout=0, exclusive=True)
        except (OSError, ValueError) as error:  # pyserial's SerialException is an OSError
            raise DeviceNotFoundError(
                f"the serial port {name} cannot be opened: {error}",
                hint="is the adapter plugged in, do you have permission, is it in use by another"
                " program?",
            ) from error
        # What came for an earlier user of the port is not our answer.
        self._port.reset_input_buffer()

    def ready(self, within_s: float) -> bool:
        """Return whether there is data."""
        until_s = time.monotonic() + within_s
        while not self._port.in_waiting:
            if time.monotonic() >= until_s:
                return False
            time.sleep(_LOOK_S)
        return True

    def receive(self) -> bytes:
        """Return the received data."""
        return bytes(self._port.read(self._port.in_waiting))

    def transmit(self, data: bytes, within_s: float) -> None:
        """Send all of the data."""
        self._port.write_timeout = within_s
        self._port.write(data)

    def close(self) -> None:
        """Close the port."""
        self._port.close()
