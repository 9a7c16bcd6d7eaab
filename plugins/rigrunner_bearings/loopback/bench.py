"""All instruments of the swing tester at once, and the station that binds them."""

from __future__ import annotations

import os
import pty
import threading
import tty
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING, Self

import numpy as np

from rigrunner_bearings.devices.swing_tester_sim.rig import closed_form_rig
from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings
from rigrunner_bearings.loopback.bridge import Bridge, BridgeServer
from rigrunner_plugins.devices.modbus.served.inverter import Inverter
from rigrunner_plugins.devices.modbus.served.press import Press
from rigrunner_plugins.devices.modbus.served.server import ModbusServer
from rigrunner_plugins.devices.plant import Plant

if TYPE_CHECKING:
    from collections.abc import Iterator


LINES_PER_S = 10.0
NOISE_N = 0.3


def line(load_n: float) -> bytes:
    """Return the cell's line for a load: 'ST,+01000.2 N' and a carriage return with line feed."""
    return f"ST,{load_n:+08.1f} N\r\n".encode("ascii")


class LoadCell:
    """A load cell that sends ten lines a second on a pty, unrequested.

    A context manager: its thread ends with it.
    """

    def __init__(self, plant: Plant, seed: int) -> None:
        self._plant = plant
        self._rng = np.random.default_rng([seed, 2])
        self._stop = threading.Event()
        self._cell_end, self._reader_end = pty.openpty()
        tty.setraw(self._reader_end)
        os.set_blocking(self._cell_end, False)
        self.port = os.ttyname(self._reader_end)
        self._thread = threading.Thread(target=self._talk, name="load cell", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        os.close(self._cell_end)
        os.close(self._reader_end)

    def _talk(self) -> None:
        while not self._stop.wait(1 / LINES_PER_S):
            load_n = self._plant.load_n + self._rng.normal(0, NOISE_N)
            with suppress(BlockingIOError):  # no reader: what is old is lost, as on a real line
                os.write(self._cell_end, line(load_n))


@dataclass(frozen=True)
class Bench:
    """Where the instruments listen."""

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
            yield Bench(server.port, modbus.port, cell.port)
        finally:
            server.shutdown()
