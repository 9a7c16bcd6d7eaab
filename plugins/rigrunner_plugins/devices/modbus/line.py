"""The connection to a unit: one request at a time, each answer checked against its request.

What waits here waits in real time: it is not done when exchanges are played back.
"""

from __future__ import annotations

import logging
import struct
import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pymodbus.exceptions import ConnectionException, ModbusException

from rigrunner.api import DeviceLostError, DeviceRejectedError, DeviceTimeoutError
from rigrunner_plugins.devices.modbus.opening import open_client
from rigrunner_plugins.devices.modbus.places import Table, address_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from pymodbus.pdu import ModbusPDU

    from rigrunner_plugins.devices.modbus.grouping import Span
    from rigrunner_plugins.devices.modbus.opening import Client
    from rigrunner_plugins.devices.modbus.places import Place
    from rigrunner_plugins.devices.modbus.settings import ModbusSettings

_BASIC = 1
"""The code that asks for the basic objects of Read Device Identification (clause 6.21)."""
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, BUSY = 1, 2, 6
NO_IDENTIFICATION = "if it does not support function 43 / 14, leave `standard` out"
_DIGITS = 4
"""Of a register behind the digit of its table; more where they do not suffice."""
_UNKNOWN = ("an exception that is not in the standard", "see the instrument's manual")
_FUNCTION = (
    "the unit does not support this kind of request: is it a holding or an input register, and"
    " does it accept `write: multiple` or `single`?"
)
_FAILURE = (
    "the unit failed to execute the request: see its display, its mode (local or remote), and"
    " whether the register may be written now"
)
_MEANINGS = {
    ILLEGAL_FUNCTION: ("illegal function", _FUNCTION),
    ILLEGAL_ADDRESS: (
        "illegal data address: it has no such register, or not that many together",
        "see the manual's list of registers",
    ),
    3: (
        "illegal data value",
        "the unit refuses the value: see the limits set in the unit itself, scale, type and order",
    ),
    4: ("device failure", _FAILURE),
    5: ("acknowledge: it needs more time for this", "increase `timeout`"),
    BUSY: ("device busy", "it is busy: see `retries`"),
    8: ("memory parity error", "the unit needs repair"),
    10: ("gateway path unavailable", "see the settings of the gateway"),
    11: (
        "the gateway's target does not answer",
        "is the unit behind the gateway on, and is `unit_id` its address?",
    ),
}
"""By exception code: its meaning and a hint (clause 7)."""


@dataclass(frozen=True)
class Request:
    """One request; its answer has the same function.

    Functions are those of the MODBUS Application Protocol Specification V1.1b3, clause 6.
    """

    text: str
    """In words."""
    unit_id: int
    function: int
    send: Callable[[Client], ModbusPDU]
    hints: Mapping[int, str] = field(default_factory=dict)
    """By exception code: a hint in place of the general one."""


def read_request(unit_id: int, table: Table, address: int, count: int) -> Request:
    """Return the request for registers or bits (clauses 6.1 to 6.4)."""

    def send(client: Client) -> ModbusPDU:
        ask = {
            Table.COIL: client.read_coils,
            Table.DISCRETE: client.read_discrete_inputs,
            Table.HOLDING: client.read_holding_registers,
            Table.INPUT: client.read_input_registers,
        }[table]
        return ask(address, count=count, device_id=unit_id)

    functions = {Table.COIL: 1, Table.DISCRETE: 2, Table.HOLDING: 3, Table.INPUT: 4}
    text = f"read {table} {address_text(address, count)}"
    return Request(text, unit_id, functions[table], send, _address_hint(table, address))


def write_request(
    unit_id: int, table: Table, address: int, words: Sequence[int], *, multiple: bool
) -> Request:
    """Return the request to write registers or coils (clauses 6.5, 6.6, 6.11 and 6.12)."""

    def send(client: Client) -> ModbusPDU:
        if table.of_bits:
            bits = [bool(word) for word in words]
            if multiple:
                return client.write_coils(address, bits, device_id=unit_id)
            return client.write_coil(address, bits[0], device_id=unit_id)
        if multiple:
            return client.write_registers(address, list(words), device_id=unit_id)
        return client.write_register(address, words[0], device_id=unit_id)

    functions = {
        (Table.COIL, False): 5,
        (Table.HOLDING, False): 6,
        (Table.COIL, True): 15,
        (Table.HOLDING, True): 16,
    }
    text = f"write {' '.join(map(str, words))} to {table} {address}"
    return Request(text, unit_id, functions[table, multiple], send, _address_hint(table, address))


def identification_request(unit_id: int, first_object: int) -> Request:
    """Return the request for the basic identification, from an object on (clause 6.21)."""

    def send(client: Client) -> ModbusPDU:
        return client.read_device_information(
            read_code=_BASIC, object_id=first_object, device_id=unit_id
        )

    hints = {ILLEGAL_FUNCTION: NO_IDENTIFICATION}
    return Request("read device identification", unit_id, 43, send, hints)


def _address_hint(table: Table, address: int) -> dict[int, str]:
    """Return a hint on how an address is counted, where it was copied from a manual."""
    digit = {Table.DISCRETE: "1", Table.INPUT: "3", Table.HOLDING: "4"}.get(table, "")
    reference = f", or {digit}{address + 1:0{_DIGITS}}" if digit else ""
    hint = (
        f"addresses count from 0: {table} {address} is number {address + 1} of manuals that count"
        f" from 1{reference}; a number such as 40001 is written as `reference: 40001`"
    )
    return {ILLEGAL_ADDRESS: hint}


# what it would print on stderr is in our error messages
logging.getLogger("pymodbus").addHandler(logging.NullHandler())

# Of Read Device Identification (clause 6.21): "more follows", and the number of objects there are.
_MORE = 0xFF
_MOST_OBJECTS = 256
_SHOWN_BYTES = 32
_UNREADABLE = (ModbusException, struct.error, LookupError, ValueError)
"""What pymodbus raises for no answer, and for bytes that are none."""


class Line:
    """A connection to one unit that threads may share."""

    def __init__(self, settings: ModbusSettings) -> None:
        self._settings = settings
        self._lock = threading.RLock()
        self._client: Client | None = None
        self._why = "not connected"
        self._received = b""
        self._late = False

    def open(self, timeout_s: float) -> None:
        """Open it; raise DeviceNotFoundError or DeviceTimeoutError."""
        with self._lock:
            self.close()
            self._client = open_client(self._settings, timeout_s, self._trace)

    def close(self, why: str = "not connected") -> None:
        """Close it; later requests raise DeviceLostError with the reason."""
        with self._lock:
            client, self._client, self._why = self._client, None, why
            if client is not None:
                client.close()  # type: ignore[no-untyped-call]  # pymodbus gives no type

    def read(self, span: Span) -> list[int]:
        """Return registers, or bits as 0 and 1."""
        table, count = span.table, span.count
        request = read_request(self._unit(span.unit_id), table, span.address, count)
        answer = self._ask(request)
        if table.of_bits:
            # Bits come eight to a byte (clause 6.1); pymodbus also hands out what fills the last
            # one.
            whole_bytes = -(-count // 8) * 8
            self._require(request, len(answer.bits) == whole_bytes, f"{len(answer.bits)} bits")
            return [int(bit) for bit in answer.bits[:count]]
        self._require(request, len(answer.registers) == count, f"{len(answer.registers)} registers")
        return list(answer.registers)

    def write(self, place: Place, words: Sequence[int], *, multiple: bool) -> None:
        """Write registers, or bits given as 0 and 1."""
        table, address = place.table, place.address
        request = write_request(self._unit(place.unit_id), table, address, words, multiple=multiple)
        answer = self._ask(request)
        self._require(request, answer.address == address, f"an echo of address {answer.address}")
        if multiple:
            self._require(request, answer.count == len(words), f"an echo of {answer.count} values")
        else:
            echo = [int(bit) for bit in answer.bits] if table.of_bits else list(answer.registers)
            self._require(request, echo == list(words), f"an echo of {echo}")

    def identification(self) -> dict[int, str]:
        """Return the basic objects of Read Device Identification by their number."""
        objects: dict[int, str] = {}
        object_id = 0
        for _ in range(_MOST_OBJECTS):
            answer = self._ask(identification_request(self._settings.unit_id, object_id))
            information: dict[int, bytes] = getattr(answer, "information", {})
            objects |= {
                number: value.decode("ascii", "replace").strip("\0 ")
                for number, value in information.items()
                if isinstance(value, bytes)
            }
            object_id = getattr(answer, "next_object_id", 0)
            if getattr(answer, "more_follows", 0) != _MORE or not object_id:
                break
        return objects

    def _unit(self, unit_id: int | None) -> int:
        return self._settings.unit_id if unit_id is None else unit_id

    def _ask(self, request: Request) -> ModbusPDU:
        with self._lock:
            for retries_left in range(self._settings.retries, -1, -1):
                answer = self._answer(request)
                if answer is None:
                    continue
                # The unit asks for time and a repetition, which is no refusal (clause 7).
                if answer.isError() and answer.exception_code == BUSY and retries_left:
                    time.sleep(self._settings.timeout)
                    continue
                return self._check(request, answer)
            raise self._timeout_error(request)

    def _answer(self, request: Request) -> ModbusPDU | None:
        if self._client is None:
            raise DeviceLostError(f"{request.text}: {self._why}")
        if self._late and self._settings.rtu is not None:
            # a serial answer does not say what it answers: a late one must not pass for the next
            time.sleep(self._settings.timeout)
        self._late, self._received = False, b""
        try:
            return request.send(self._client)
        except (ConnectionException, OSError) as error:  # OSError: the other end has reset it
            self.close("the connection was lost")
            raise DeviceLostError(
                f"{request.text}: {self._where(request)} closed the connection or was unplugged",
                hint="see cable and power; one that drops idle connections needs a `watchdog`",
            ) from error
        except _UNREADABLE:
            self._late = True
            return None

    def _check(self, request: Request, answer: ModbusPDU) -> ModbusPDU:
        if answer.isError():
            code = answer.exception_code
            meaning, hint = _MEANINGS.get(code, _UNKNOWN)
            raise DeviceRejectedError(
                f"{request.text}: {self._where(request)} says {meaning} (exception {code})",
                hint=request.hints.get(code, hint),
            )
        function = answer.function_code
        self._require(request, function == request.function, f"an answer to function {function}")
        return answer

    def _require(self, request: Request, holds: bool, got: str) -> None:  # noqa: FBT001  (reads as a sentence)
        if not holds:
            self._late = True
            raise DeviceRejectedError(
                f"{request.text}: {self._where(request)} gives a wrong answer: {got}",
                hint="are there two masters, or two units with the same address?",
            )

    def _timeout_error(self, request: Request) -> DeviceTimeoutError:
        where, within = self._where(request), f"within {self._settings.timeout:g} s"
        serial = ", baud, parity and stop_bits" if self._settings.rtu is not None else ""
        if not self._received:
            return DeviceTimeoutError(
                f"{request.text}: no answer from {where} {within}",
                hint=f"is it switched on, and are wiring, unit_id{serial} correct?",
            )
        received = self._received[:_SHOWN_BYTES].hex(" ")
        return DeviceTimeoutError(
            f"{request.text}: no readable answer from {where} {within}, only: {received}",
            hint=f"are unit_id{serial} correct, and does it use Modbus?",
        )

    def _where(self, request: Request) -> str:
        return self._settings.where_is(request.unit_id)

    def _trace(self, sending: bool, data: bytes) -> bytes:  # noqa: FBT001  (pymodbus calls it so)
        if not sending:
            self._received = data
        return data
