"""All instruments of the swing tester at once, and the station that binds them."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING

from rigrunner_bearings.devices.swing_tester_sim.rig import closed_form_rig
from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings
from rigrunner_bearings.loopback.bridge import Bridge, BridgeServer
from rigrunner_bearings.loopback.cell import LoadCell
from rigrunner_plugins.devices.modbus.served.inverter import Inverter
from rigrunner_plugins.devices.modbus.served.press import Press
from rigrunner_plugins.devices.modbus.served.server import ModbusServer
from rigrunner_plugins.devices.plant import Plant

if TYPE_CHECKING:
    from collections.abc import Iterator


@dataclass(frozen=True)
class Bench:
    """Where the instruments listen."""

    plant: Plant
    bridge_port: int
    modbus_port: int
    cell_port: str

    def station(self) -> str:
        """Return the text of the station that binds these instruments."""
        text = files("rigrunner_bearings.loopback").joinpath("station.yaml").read_text("utf-8")
        return Template(text).substitute(
            bridge_port=self.bridge_port, modbus_port=self.modbus_port, cell_port=self.cell_port
        )


@contextmanager
def running_bench(seed: int = 1, bridge_port: int = 0, modbus_port: int = 0) -> Iterator[Bench]:
    """Run the instruments on 127.0.0.1 until the block ends; port 0 is any that is free.

    Raises OSError where a port is taken.
    """
    settings = SwingTesterSimSettings(seed=seed)
    plant = Plant()
    bridge = Bridge(closed_form_rig(settings.parameters()), plant, seed)
    with (
        BridgeServer(bridge, port=bridge_port) as server,
        ModbusServer([Inverter(plant), Press(plant)], port=modbus_port) as modbus,
        LoadCell(plant, seed) as cell,
    ):
        threading.Thread(target=server.serve_forever, name="bridge", daemon=True).start()
        try:
            yield Bench(plant, server.port, modbus.port, cell.port)
        finally:
            server.shutdown()
