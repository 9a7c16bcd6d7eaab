"""A power supply that keeps its outputs in a file: they outlive every process.

No test can look at a real rig after `kill -9`; this one is a file. Its plugin does not declare
itself simulated, so that everything for real devices applies.
"""

from __future__ import annotations

import json

PLUGIN = """
import ctypes
import json
import os
import time

from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity
from rigrunner.api.driver import Driver
from rigrunner.api.errors import DeviceLostError
from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner.api.settings import Settings

api_version = 1


class SupplySettings(Settings):
    file: str
    serial: str = "1"
    non_blocking: bool = False

    def physical_addresses(self):
        return (f"file:{self.file}",)


def _abort():
    ctypes.PyDLL(None).abort()


def _crash():
    ctypes.string_at(0)


def _hold_gil():
    ctypes.PyDLL(None).sleep(600)  # PyDLL keeps the lock of the interpreter: no thread goes on


def _sleep():
    time.sleep(600)


TROUBLES = {"abort": _abort, "crash": _crash, "gil": _hold_gil, "sleep": _sleep}


class Supply(Driver):
    channels = (ChannelInfo("voltage", "V", "Voltage"), ChannelInfo("speed", "Hz", "Speed"))
    drives = (
        DriveInfo("voltage", "V", "Voltage", 0.0, 60.0, tolerance=0.5),
        DriveInfo("speed", "Hz", "Speed", 0.0, 50.0, tolerance=0.5),
    )

    def __init__(self, settings, context):
        super().__init__(context)
        self._serial = settings.serial
        self.non_blocking = settings.non_blocking
        self._file = context.folder / settings.file

    def _all(self):
        return json.loads(self._file.read_text())

    def open(self, timeout_s):
        if not self._file.exists():
            raise DeviceLostError("the supply is unplugged")
        while self._all().get("is_held"):  # by whoever looks at what happens meanwhile
            time.sleep(0.02)
        return Identity("Example", "supply", self._serial)

    def get(self, channel):
        trouble = self._file.with_name("trouble")
        if self._all()["voltage"] == 40.0 and trouble.exists():
            name = trouble.read_text()
            trouble.unlink()
            TROUBLES[name]()
        return self._all()[channel]

    def put(self, drive, value):
        part = self._file.with_suffix(f".{os.getpid()}")
        part.write_text(json.dumps(self._all() | {drive: value}))
        if self._all().get("stuck") != drive:
            part.replace(self._file)


@hookimpl
def rigrunner_devices():
    return [
        DeviceRecord(
            name="supply",
            help="a power supply that keeps its voltages in a file",
            settings=SupplySettings,
            factory=Supply,
        )
    ]
"""
STATION = """\
rigrunner: station/1
id: {id}
title: Power supply
devices:
  psu:
    type: supply
    plugin: supply
    settings: {{file: supply.json}}
instruments:
  - {{channel: psu.voltage, measures: voltage, serial: "1", calibration: trial, accuracy: 0.1 V}}
plugins: plugins
safety: {{guardian: no}}
"""
GUARDED = ("guardian: no", "guardian: yes, patience: {connect: 5 s, answer: 1 s}")
"""Replacement that gives the station the default guardian."""
PROCEDURE = """\
rigrunner: procedure/2
id: STEPS
revision: "A"
title: Voltage steps
measurand: {symbol: U, name: voltage}
uses: {psu: supply}
setup:
  - confirm: {text: "Put the specimen between the terminals, hands out", unattended: yes}
main:
  - set: {psu.speed: 20 Hz}
  - repeat:
      times: 12
      steps:
        - set: {psu.voltage: 40 V}
        - measure: {channels: [psu.voltage], name: steps}
        - wait: {time: 0.05 s}
        - set: {psu.voltage: 30 V}
        - measure: {channels: [psu.voltage], name: steps}
        - wait: {time: 0.05 s}
teardown:
  - set: {psu.voltage: 0 V}
"""


class SupplyLab:
    """A folder with station, procedure, plugin, and the supply's file."""

    def __init__(self, folder, station_id="supply"):
        self.folder = folder
        self.station_id = station_id
        (folder / "plugins").mkdir(parents=True)
        (folder / "plugins" / "supply.py").write_text(PLUGIN, encoding="utf-8")
        self.station = self.add_station("station.yaml", station_id)
        self.procedure = folder / "procedure.yaml"
        self.procedure.write_text(PROCEDURE, encoding="utf-8")
        self.runs = folder / "runs"
        self.state = folder / "supply.json"
        self.put(voltage=0.0, speed=0.0)

    def add_station(self, name, station_id, *replacements):
        """Write one more station of the same supply."""
        text = STATION.format(id=station_id)
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new)
        (self.folder / name).write_text(text, encoding="utf-8")
        return self.folder / name

    def put(self, **values):
        """Set values of the supply."""
        state = json.loads(self.state.read_text()) if self.state.exists() else {}
        self.state.write_text(json.dumps(state | values), encoding="utf-8")

    def outputs(self):
        """Return the present voltage and speed of the supply."""
        state = json.loads(self.state.read_text())
        return state["voltage"], state["speed"]
