"""The connection to a unit: one request at a time, each answer checked against its request.

What waits here waits in real time: it is not done when exchanges are played back.
"""

from __future__ import annotations

import logging
import struct
import threading
import time
from typing import TYPE_CHECKING

from pymodbus.exceptions import ConnectionException, ModbusException

from rigrunner.api.errors import (
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner_plugins.devices.modbus.opening import open_client
from rigrunner_plugins.devices.modbus.places import Table, span
from rigrunner_plugins.devices.modbus.refusals import (
    BUSY,
    ILLEGAL_ADDRESS,
    ILLEGAL_FUNCTION,
    NO_IDENTIFICATION,
    counted,
    meaning,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from pymodbus.pdu import ModbusPDU

    from rigrunner_plugins.devices.modbus.opening import Client
    from rigrunner_plugins.devices.modbus.settings import ModbusSettings

# what it would print on stderr stands in our errors, in words
logging.getLogger("pymodbus").addHandler(logging.NullHandler())

_MORE = 0xFF
_MOST_OBJECTS = 256
_UNREADABLE = (ModbusException, struct.error, LookupError, ValueError)
"""What pymodbus raises for no answer, and for bytes that are none."""


class Line:
    """A connection to one unit that threads may share."""

    def __init__(self, settings: ModbusSettings) -> None:
        self._settings = settings
        self._lock = threading.RLock()
        self._client: Client | None = None
        self._why = "not connected"
        self._heard = b""
        self._late = False

    def open(self, timeout_s: float) -> None:
        """Open it; raise DeviceNotFoundError or DeviceTimeoutError."""
        with self._lock:
            self.close()
            self._client = open_client(self._settings, timeout_s, self._hear)

    def close(self, why: str = "not connected") -> None:
        """Close it; what is asked from then on raises DeviceLostError with the reason."""
        with self._lock:
            client, self._client, self._why = self._client, None, why
            if client is not None:
                client.close()  # type: ignore[no-untyped-call]  # pymodbus gives no type

    def read(self, table: Table, address: int, count: int) -> list[int]:
        """Return registers, or bits as 0 and 1."""
        unit = self._settings.unit_id
        asked = f"read {table} {span(address, count)}"
        requests: dict[Table, tuple[int, Callable[[Client], ModbusPDU]]] = {
            Table.COIL: (1, lambda c: c.read_coils(address, count=count, device_id=unit)),
            Table.DISCRETE: (
                2,
                lambda c: c.read_discrete_inputs(address, count=count, device_id=unit),
            ),
            Table.HOLDING: (
                3,
                lambda c: c.read_holding_registers(address, count=count, device_id=unit),
            ),
            Table.INPUT: (
                4,
                lambda c: c.read_input_registers(address, count=count, device_id=unit),
            ),
        }
        function, request = requests[table]
        answer = self._ask(asked, function, request, {ILLEGAL_ADDRESS: counted(table, address)})
        if table.of_bits:
            whole_bytes = -(-count // 8) * 8
            self._need(asked, len(answer.bits) == whole_bytes, f"{len(answer.bits)} bits")
            return [int(bit) for bit in answer.bits[:count]]
        self._need(asked, len(answer.registers) == count, f"{len(answer.registers)} registers")
        return list(answer.registers)

    def write(self, table: Table, address: int, values: Sequence[int], *, multiple: bool) -> None:
        """Write registers, or bits given as 0 and 1."""
        unit, words, bits = self._settings.unit_id, list(values), [bool(each) for each in values]
        asked = f"write {' '.join(map(str, values))} to {table} {address}"
        requests: dict[tuple[Table, bool], tuple[int, Callable[[Client], ModbusPDU]]] = {
            (Table.COIL, False): (5, lambda c: c.write_coil(address, bits[0], device_id=unit)),
            (Table.HOLDING, False): (
                6,
                lambda c: c.write_register(address, words[0], device_id=unit),
            ),
            (Table.COIL, True): (15, lambda c: c.write_coils(address, bits, device_id=unit)),
            (Table.HOLDING, True): (
                16,
                lambda c: c.write_registers(address, words, device_id=unit),
            ),
        }
        function, request = requests[table, multiple]
        answer = self._ask(asked, function, request, {ILLEGAL_ADDRESS: counted(table, address)})
        self._need(asked, answer.address == address, f"an echo of address {answer.address}")
        if multiple:
            self._need(asked, answer.count == len(words), f"an echo of {answer.count} values")
        else:
            echo = [int(bit) for bit in answer.bits] if table.of_bits else list(answer.registers)
            self._need(asked, echo == words, f"an echo of {echo}")

    def identification(self) -> dict[int, str]:
        """Return the basic objects of Read Device Identification (43 / 14) by their number."""
        found: dict[int, str] = {}
        wanted = 0
        for _ in range(_MOST_OBJECTS):
            answer = self._ask(
                "read device identification",
                43,
                lambda client: client.read_device_information(
                    read_code=1,
                    object_id=wanted,  # noqa: B023  (called before the next turn)
                    device_id=self._settings.unit_id,
                ),
                {ILLEGAL_FUNCTION: NO_IDENTIFICATION},
            )
            information: dict[int, bytes] = getattr(answer, "information", {})
            found |= {
                number: value.decode("ascii", "replace").strip("\0 ")
                for number, value in information.items()
                if isinstance(value, bytes)
            }
            wanted = getattr(answer, "next_object_id", 0)
            if getattr(answer, "more_follows", 0) != _MORE or not wanted:
                break
        return found

    def _ask(
        self,
        asked: str,
        function: int,
        request: Callable[[Client], ModbusPDU],
        hints: Mapping[int, str],
    ) -> ModbusPDU:
        with self._lock:
            for left in range(self._settings.retries, -1, -1):
                answer = self._answer(asked, request)
                if answer is None:
                    continue
                if answer.isError() and answer.exception_code == BUSY and left:
                    time.sleep(self._settings.timeout)
                    continue
                return self._checked(asked, function, answer, hints)
            raise self._unanswered(asked)

    def _answer(self, asked: str, request: Callable[[Client], ModbusPDU]) -> ModbusPDU | None:
        if self._client is None:
            raise DeviceLostError(f"{asked}: {self._why}")
        if self._late and self._settings.rtu is not None:
            # a serial answer does not say what it answers: a late one must not pass for the next
            time.sleep(self._settings.timeout)
        self._late, self._heard = False, b""
        try:
            return request(self._client)
        except ConnectionException as error:
            self.close("the connection was lost")
            raise DeviceLostError(
                f"{asked}: {self._settings.where} closed the connection or was unplugged",
                hint="see cable and power; one that drops idle connections needs a `watchdog`",
            ) from error
        except _UNREADABLE:
            self._late = True
            return None

    def _checked(
        self, asked: str, function: int, answer: ModbusPDU, hints: Mapping[int, str]
    ) -> ModbusPDU:
        if answer.isError():
            said, hint = meaning(answer.exception_code)
            raise DeviceRejectedError(
                f"{asked}: {self._settings.where} says {said}",
                hint=hints.get(answer.exception_code, hint),
            )
        self._need(
            asked, answer.function_code == function, f"an answer to function {answer.function_code}"
        )
        return answer

    def _need(self, asked: str, holds: bool, got: str) -> None:  # noqa: FBT001  (reads as a sentence)
        if not holds:
            self._late = True
            raise DeviceRejectedError(
                f"{asked}: {self._settings.where} answers something else: {got}",
                hint="are there two masters, or two units with the same address?",
            )

    def _unanswered(self, asked: str) -> DeviceTimeoutError:
        where, within = self._settings.where, f"within {self._settings.timeout:g} s"
        serial = ", baud, parity and stop_bits" if self._settings.rtu is not None else ""
        if not self._heard:
            return DeviceTimeoutError(
                f"{asked}: no answer from {where} {within}",
                hint=f"is it on, and are the wiring, unit_id{serial} right?",
            )
        return DeviceTimeoutError(
            f"{asked}: no readable answer from {where} {within}, only: {self._heard[:32].hex(' ')}",
            hint=f"are unit_id{serial} right, and does it talk Modbus at all?",
        )

    def _hear(self, sending: bool, data: bytes) -> bytes:  # noqa: FBT001  (pymodbus calls it so)
        if not sending:
            self._heard = data
        return data
