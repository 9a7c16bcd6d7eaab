"""A simulated instrument, served by a Modbus server of its own on loopback."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner_plugins.devices.modbus.served.inverter import Inverter
from rigrunner_plugins.devices.modbus.served.press import Press
from rigrunner_plugins.devices.modbus.served.server import ModbusServer
from rigrunner_plugins.devices.plant import Plant

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_plugins.devices.modbus.settings import Simulator


def serve(simulator: Simulator, unit_id: int, now_s: Callable[[], float]) -> ModbusServer:
    """Return a server that listens; its plant moves in the time that it is told."""
    plant = Plant(now_s=now_s)
    unit = Inverter(plant, unit_id) if simulator == "inverter" else Press(plant, unit_id)
    server = ModbusServer([unit])
    server.start()
    return server
