"""A Modbus TCP server on loopback, of units that provide their registers."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Protocol, Self

from pymodbus.constants import ExcCodes
from pymodbus.pdu.mei_message import ReadDeviceInformationResponse
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from rigrunner_plugins.devices.modbus.served.inverter import Inverter
from rigrunner_plugins.devices.modbus.served.press import Press
from rigrunner_plugins.devices.plant import Plant

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from pymodbus.pdu import ModbusPDU

    from rigrunner_plugins.devices.modbus.settings import Simulator

_TICK_S = 0.02
"""How often the units look at the time."""
_STARTS_WITHIN_S = 10.0
_OF_BITS = {1, 2, 5, 15}
"""The functions that read or write coils and discrete inputs."""
_READ_INPUTS = 4


class Unit(Protocol):
    """An instrument of registers alone; all is called from the server's thread."""

    unit_id: int
    identity: Mapping[int, str]
    """Objects of Read Device Identification by number: 0 maker, 1 product, 2 revision."""

    def inputs(self) -> Sequence[int]:
        """Return the input registers from address 0."""
        ...

    def holding(self) -> Sequence[int]:
        """Return the holding registers from address 0."""
        ...

    def written(self, address: int, words: Sequence[int]) -> ExcCodes | None:
        """Accept values for holding registers, or refuse them."""
        ...

    def tick(self) -> None:
        """Look at the time; called again and again."""
        ...


class ModbusServer:
    """Listens on 127.0.0.1 from `start` to `stop`; a thread of its own serves."""

    def __init__(self, units: Sequence[Unit], port: int = 0) -> None:
        self.port = port
        self._units = units
        self._ready = threading.Event()
        self._failed: Exception | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ended: asyncio.Event | None = None
        self._thread = threading.Thread(target=self._serve, name="modbus server", daemon=True)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(self) -> None:
        """Listen; return once the port is known; raise OSError if it is taken."""
        self._thread.start()
        self._ready.wait(_STARTS_WITHIN_S)
        if self._failed is not None:
            raise OSError(f"no Modbus server on port {self.port}: {self._failed}")

    def stop(self) -> None:
        """Drop all connections and listen no more; idempotent."""
        if self._loop is not None and self._ended is not None:
            with suppress(RuntimeError):  # the loop is closed: it was stopped before
                self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join()

    def _serve(self) -> None:
        try:
            asyncio.run(self._run())
        except (OSError, RuntimeError) as error:
            self._failed = error
            self._ready.set()

    async def _run(self) -> None:
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        server = ModbusTcpServer(
            [sim_device(unit) for unit in self._units],
            address=("127.0.0.1", self.port),
            trace_pdu=_identifier(self._units),
        )
        await server.serve_forever(background=True)
        self.port = server.transport.sockets[0].getsockname()[1]  # type: ignore[attr-defined]  # a Server
        self._ready.set()
        while not self._ended.is_set():
            for unit in self._units:
                unit.tick()
            await asyncio.sleep(_TICK_S)
        await server.shutdown()  # type: ignore[no-untyped-call]  # pymodbus gives no type


def serve(simulator: Simulator, unit_id: int, now_s: Callable[[], float]) -> ModbusServer:
    """Return a listening server of one instrument, which moves in the time of `now_s`."""
    plant = Plant(now_s=now_s)
    unit = Inverter(plant, unit_id) if simulator == "inverter" else Press(plant, unit_id)
    server = ModbusServer([unit])
    server.start()
    return server


def sim_device(unit: Unit) -> SimDevice:
    """Return the unit as pymodbus serves it, over TCP or any other line."""

    async def act(  # noqa: PLR0917  (called so by pymodbus)
        function: int,
        start: int,  # noqa: ARG001  (all tables start at 0)
        address: int,
        count: int,
        registers: list[int],
        values: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        if function in _OF_BITS:
            return ExcCodes.ILLEGAL_ADDRESS
        if values is not None:
            return unit.written(address, [int(value) for value in values])
        present = unit.inputs() if function == _READ_INPUTS else unit.holding()
        registers[address : address + count] = present[address : address + count]
        return None

    # Input and holding registers differ, so pymodbus wants four tables; `act` refuses these two.
    bit = SimData(0, values=[False] * 16, datatype=DataType.BITS)
    blocks = (
        [bit],
        [bit],
        [SimData(0, values=list(unit.holding()), datatype=DataType.REGISTERS)],
        [SimData(0, values=list(unit.inputs()), datatype=DataType.REGISTERS)],
    )
    return SimDevice(unit.unit_id, blocks, action=act)


def _identifier(units: Sequence[Unit]) -> Callable[[bool, ModbusPDU], ModbusPDU]:
    """Return what puts each unit's own identity into an answer; pymodbus has one for all."""
    identities = {unit.unit_id: dict(unit.identity) for unit in units}

    def identified(sending: bool, pdu: ModbusPDU) -> ModbusPDU:  # noqa: FBT001  (called so)
        if sending and isinstance(pdu, ReadDeviceInformationResponse):
            pdu.information = identities[pdu.dev_id]
        return pdu

    return identified
