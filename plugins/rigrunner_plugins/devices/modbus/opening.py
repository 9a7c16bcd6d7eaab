"""Opens the client of pymodbus, so that a failure keeps its reason.

The client's own `connect` answers False for every reason; so its socket or port is opened here.
"""

from __future__ import annotations

import socket
from contextlib import suppress
from typing import TYPE_CHECKING, TypeAlias

from pymodbus.client import ModbusSerialClient, ModbusTcpClient

from rigrunner.api import DeviceNotFoundError, DeviceTimeoutError
from rigrunner_plugins.devices.extras import reason_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_plugins.devices.modbus.settings import ModbusSettings, Rtu, Tcp

Client: TypeAlias = ModbusTcpClient | ModbusSerialClient
_TCP_OPENS_WITHIN_S = 3.0
"""Enough for one lost packet: TCP repeats the first one after 1 s (RFC 6298)."""
_PARITY = {"even": "E", "odd": "O", "none": "N"}


def open_client(
    settings: ModbusSettings, timeout_s: float, trace: Callable[[bool, bytes], bytes]
) -> Client:
    """Return an open client; raise DeviceNotFoundError or DeviceTimeoutError."""
    if settings.tcp is not None:
        within_s = min(timeout_s, max(_TCP_OPENS_WITHIN_S, settings.timeout))
        return _open_tcp(settings.tcp, settings.timeout, within_s, trace)
    if settings.rtu is not None:
        return _open_rtu(settings.rtu, settings.timeout, trace)
    raise AssertionError("neither tcp nor rtu")


def _open_tcp(
    tcp: Tcp, answer_s: float, timeout_s: float, trace: Callable[[bool, bytes], bytes]
) -> ModbusTcpClient:
    # No retries of the client: `Line` repeats, and distinguishes a busy unit from a silent one.
    client = ModbusTcpClient(
        tcp.host, port=tcp.port, timeout=answer_s, retries=0, trace_packet=trace
    )
    try:
        client.socket = socket.create_connection((tcp.host, tcp.port), timeout_s)
    except TimeoutError as error:
        raise DeviceTimeoutError(
            f"{tcp.host}:{tcp.port} does not answer within {timeout_s:g} s",
            hint="is it switched on, in the same network, and not behind a firewall?",
        ) from error
    except OSError as error:
        raise DeviceNotFoundError(
            f"{tcp.host}:{tcp.port} cannot be reached: {error.strerror or error}",
            hint="is it switched on, are host and port correct, or does another master use its"
            " only connection?",
        ) from error
    return client


def _open_rtu(
    rtu: Rtu, answer_s: float, trace: Callable[[bool, bytes], bytes]
) -> ModbusSerialClient:
    import serial  # noqa: PLC0415  (Modbus TCP does without it)

    client = ModbusSerialClient(
        rtu.port,
        baudrate=rtu.baud,
        parity=_PARITY[rtu.parity],
        stopbits=rtu.stop_bits,
        timeout=answer_s,
        retries=0,
        trace_packet=trace,
    )
    try:
        client.socket = serial.serial_for_url(
            rtu.port,
            baudrate=rtu.baud,
            parity=_PARITY[rtu.parity],
            stopbits=rtu.stop_bits,
            timeout=answer_s,
            write_timeout=answer_s,
            # 1.5 characters up to 19200 baud: a longer silence ends a message (Serial Line V1.02,
            # 2.5.1.1).
            inter_byte_timeout=client.inter_byte_timeout,
            exclusive=True,
        )
    except (OSError, ValueError) as error:
        raise DeviceNotFoundError(
            f"the serial port {rtu.port} cannot be opened: {reason_of(error)}",
            hint="is the adapter plugged in, is it in use by another program, and do you have"
            " permission (on Linux the group dialout)?",
        ) from error
    # A port that fails here fails at the first request as well, with a better message.
    with suppress(OSError):
        client.socket.reset_input_buffer()
    return client
