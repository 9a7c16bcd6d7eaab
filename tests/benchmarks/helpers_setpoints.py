"""A plan of many set-points on a device that takes no time, to measure the program itself.

The set-points are points of a scan, or steps of a sweep. Run as a program, in tests/, `python -m
benchmarks.helpers_setpoints FOLDER POINTS [sweep]` prints each finished point.
"""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path
from textwrap import indent

from rigrunner.api.events import Event, Scanned, StepEnded
from rigrunner.clock import WallClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute

HIGHEST_N, LIMIT_NM = 2000.0, 3.0

_PLUGIN = '''
from rigrunner.api.devices import ChannelInfo, DriveInfo, Identity
from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner.api.settings import Settings, YesNo

api_version = 1


class PressSettings(Settings):
    blocking: YesNo = False


class Press:
    """A press with a transducer; both do nothing but remember."""

    channels = (ChannelInfo("torque", "N·m", "Torque"),)
    drives = (DriveInfo("load", "N", "Load", 0.0, 2000.0),)

    def __init__(self, settings, context):
        self.non_blocking = not settings.blocking
        self._load_n = 0.0

    def connect(self, timeout_s):
        return Identity("Rigrunner", "press", "SIM-PR-01", simulated=True)

    def close(self):
        pass

    def make_safe(self):
        self._load_n = 0.0
        return {"load": 0.0}

    def set(self, drive, value):
        self._load_n = value

    def read_back(self, drive):
        return self._load_n

    def read(self, channels):
        return {"torque": 1e-3 * self._load_n}


@hookimpl
def rigrunner_devices():
    return [
        DeviceRecord(
            name="bench_press",
            help="Press that does nothing",
            settings=PressSettings,
            factory=Press,
            simulated=True,
        )
    ]
'''

_STATION = """\
rigrunner: station/1
id: bench
title: Press that does nothing
plugins: plugins
devices:
  press: {{type: press, plugin: bench_press, settings: {{blocking: {blocking}}}}}
durability: {{sync: {sync}}}
"""

_PROCEDURE = """\
rigrunner: procedure/2
id: SETPOINTS
revision: "A"
title: Set-points
measurand: {{symbol: Td, name: torque under load, unit: N·m}}
uses: {{press: press}}
main:
{main}
teardown:
  - set: {{press.load: 0 N}}
"""
_SCAN = """\
  - scan:
      set: press.load
      over: [{values}]
      channels: [press.torque]
      limits: {{press.torque: {{max: 3 N·m}}}}
"""
_SWEEP = """\
  - sweep:
      set: press.load
      over: [{values}]
      steps:
        - measure:
            channels: [press.torque]
            limits: {{press.torque: {{max: 3 N·m}}}}
"""
_REPEATED = """\
  - repeat:
      times: {times}
      steps:
{main}"""


def lab_of(
    folder: Path,
    points: int,
    *,
    blocking: bool = False,
    sync: str = "each_second",
    sweep: bool = False,
    times: int = 1,
) -> tuple[Path, Path]:
    """Write procedure, station and plugin into a folder; return the first two.

    All points are repeated `times`: a file has 20,000 values at most.
    """
    (folder / "plugins").mkdir(parents=True)
    (folder / "plugins" / "bench_press.py").write_text(_PLUGIN, encoding="utf-8")
    station, procedure = folder / "station.yaml", folder / "procedure.yaml"
    text = _STATION.format(blocking="yes" if blocking else "no", sync=sync)
    station.write_text(text, encoding="utf-8")
    values = ", ".join(f"{load_n:.6g} N" for load_n in loads_n(points))
    main = (_SWEEP if sweep else _SCAN).format(values=values)
    if times > 1:
        main = _REPEATED.format(times=times, main=indent(main, 4 * " "))
    procedure.write_text(_PROCEDURE.format(main=main), encoding="utf-8")
    return procedure, station


def loads_n(points: int) -> list[float]:
    """Return the set-points of a sweep of this number of points."""
    return [HIGHEST_N * (index + 1) / points for index in range(points)]


def run_until_killed(folder: Path, points: int, *, sweep: bool) -> None:
    """Run all points, and print the load of each when its end is reported."""
    procedure, station = lab_of(folder, points, sweep=sweep)
    planned = plan_run(procedure, station, load_registry(), WallClock())
    execute(
        planned,
        runs=folder / "runs",
        inputs={},
        partners={},
        answers=UnattendedAnswers(),
        stop=threading.Event(),
        listeners=[_print_load],
    )


def _print_load(event: Event) -> None:
    if isinstance(event, (Scanned, StepEnded)) and event.measurement:
        os.write(1, f"{event.setpoints['press.load']!r}\n".encode())


if __name__ == "__main__":
    run_until_killed(Path(sys.argv[1]), int(sys.argv[2]), sweep="sweep" in sys.argv)
