"""Requests to a unit: what is asked, by which function of pymodbus, and what its answer must be.

The functions are those of the MODBUS Application Protocol Specification V1.1b3, clause 6.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner_plugins.devices.modbus.places import Table, span
from rigrunner_plugins.devices.modbus.refusals import (
    ILLEGAL_ADDRESS,
    ILLEGAL_FUNCTION,
    NO_IDENTIFICATION,
    counted,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from pymodbus.pdu import ModbusPDU

    from rigrunner_plugins.devices.modbus.opening import Client

_BASIC = 1


@dataclass(frozen=True)
class Request:
    """One request; its answer has the same function."""

    asked: str
    """In words."""
    unit_id: int
    function: int
    send: Callable[[Client], ModbusPDU]
    hints: Mapping[int, str] = field(default_factory=dict)
    """What to say of an exception code in place of what is said in general."""


def reading(unit_id: int, table: Table, address: int, count: int) -> Request:
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
    asked = f"read {table} {span(address, count)}"
    return Request(asked, unit_id, functions[table], send, _if_not_there(table, address))


def writing(
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
    asked = f"write {' '.join(map(str, words))} to {table} {address}"
    return Request(asked, unit_id, functions[table, multiple], send, _if_not_there(table, address))


def identifying(unit_id: int, first_object: int) -> Request:
    """Return the request for the basic identification, from an object on (clause 6.21)."""

    def send(client: Client) -> ModbusPDU:
        return client.read_device_information(
            read_code=_BASIC, object_id=first_object, device_id=unit_id
        )

    hints = {ILLEGAL_FUNCTION: NO_IDENTIFICATION}
    return Request("read device identification", unit_id, 43, send, hints)


def _if_not_there(table: Table, address: int) -> dict[int, str]:
    return {ILLEGAL_ADDRESS: counted(table, address)}
