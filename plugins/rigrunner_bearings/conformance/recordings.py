"""Recordings of the simulated rigs with what is true of them, made once in a process."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DeviceContext, Recording, RunData
from rigrunner.clock import SimulatedClock, utc_text
from rigrunner.run.locate import find_station
from rigrunner.station import load_station
from rigrunner_bearings.api.rig import torque_instruments
from rigrunner_bearings.study.bench import LOAD_N, Value
from rigrunner_bearings.study.coverage import limits
from rigrunner_bearings.study.coverage_rigs import draw
from rigrunner_bearings.study.recording import record_bench
from rigrunner_bearings.study.tools import tools
from rigrunner_bearings.torque.settings import NO_LOAD

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from rigrunner.api import Array

CLOSED_FORM, TIME_DOMAIN, ROTATION = "swing_tester_sim", "swing_tester_ode", "rotation_tester_sim"
FREQUENCIES_HZ = (5.0, 10.0, 20.0, 28.0, 35.0)
CYCLES = 12
RUNNING_IN_HZ, RUNNING_IN_TURNS = 10 / 60, 3.0
STARTS, START_S, REST_S, START_HZ = 8, 1.5, 30.0, 2 / 60
CHANNELS = ("angle", "torque")


@dataclass(frozen=True, eq=False)
class Runs:
    """What a compensation takes, and the truth at each set-point."""

    loaded: RunData
    no_load: RunData | None
    truths_nm: tuple[float, ...]

    def changed(self, change: Callable[[RunData], RunData]) -> Runs:
        """Return both runs with one change."""
        no_load = None if self.no_load is None else change(self.no_load)
        return replace(self, loaded=change(self.loaded), no_load=no_load)


def each_recording(change: Callable[[Recording], Recording]) -> Callable[[RunData], RunData]:
    """Return what changes every recording of a run."""
    return lambda run: replace(run, recordings=tuple(map(change, run.recordings)))


@lru_cache(maxsize=32)
def swings(simulator: str, number: int, rate_hz: float | None = None) -> Runs:
    """Return both runs of a random rig, as the study of coverage draws them."""
    shared = tools()
    station = shared.measured_station
    rig = draw(simulator, np.random.default_rng([1, number]), station, limits())
    bench = replace(rig.bench, cycles=CYCLES, frequencies_hz=FREQUENCIES_HZ)
    if rate_hz is not None:
        rate = {"sensors.rate": Value(rate_hz, "Hz")}
        no_load, loaded = {**bench.no_load, **rate}, {**bench.loaded, **rate}
        bench = replace(bench, no_load=no_load, loaded=loaded)
    recorded = record_bench(bench, shared.registry, rig.station)
    # As the study of coverage does: results are stated for the load that is said to act.
    truths = np.array(recorded.truths_nm) * LOAD_N / bench.load_n
    return Runs(recorded.loaded, recorded.no_load, tuple(map(float, truths)))


def run_of_swings(number: int) -> RunData:
    """Return the loaded run of a random rig, with its no-load run beside it."""
    runs = swings(CLOSED_FORM, number)
    assert runs.no_load is not None  # noqa: S101  (a rig that swings has one)
    return replace(runs.loaded, partners={NO_LOAD: runs.no_load})


def run_of_starts(number: int) -> RunData:
    """Return a run of starts from rest."""
    return starts(number).loaded


@lru_cache(maxsize=8)
def starts(number: int, rate_hz: float | None = None) -> Runs:
    """Return a run of starts from rest of one bearing."""
    station = load_station(find_station("simulated_bench")).model
    settings = dict(next(iter(station.devices.values())).settings) | {"seed": number}
    if rate_hz is not None:
        settings["sensors"] = dict(settings.get("sensors", {})) | {"rate": f"{rate_hz:g} Hz"}
    clock = SimulatedClock()
    device: Any = tools().registry.make_device(
        ROTATION, settings, DeviceContext("tester", clock, Path())
    )
    device.connect(1.0)
    zero = float(np.mean(_streamed(device, 1.0)["tester.torque"]))
    device.set("frequency", RUNNING_IN_HZ)
    clock.sleep(RUNNING_IN_TURNS / RUNNING_IN_HZ)
    device.set("frequency", 0.0)
    device.set("start_frequency", START_HZ)
    recordings, truths = [], []
    for index in range(STARTS):
        clock.sleep(REST_S)
        recordings.append(
            Recording(
                name=f"{index:03d}",
                rate_hz=device.sample_rate_hz,
                started_utc=utc_text(clock.utc()),
                setpoints={"tester.frequency": 0.0, "tester.start_frequency": START_HZ},
                channels=_streamed(device, START_S),
                units={"tester.angle": "rad", "tester.torque": "N·m"},
            )
        )
        truths.append(device.truth()["breakaway_torque_nm"])
    run = RunData(
        run_id=f"starts-{number}",
        procedure_id="starts",
        procedure_revision="",
        procedure_title="starts",
        station_id=station.id,
        started_utc=utc_text(clock.utc()),
        ended_utc=utc_text(clock.utc()),
        outcome="completed",
        inputs={},
        rig_keys=station.rig,
        instruments=torque_instruments(station.instruments),
        zeros={"tester.torque": zero},
        recordings=tuple(recordings),
    )
    return Runs(run, None, (float(np.mean(truths)),))


def _streamed(device: Any, duration_s: float) -> dict[str, Array]:
    blocks = list(device.stream(CHANNELS, duration_s, threading.Event()))
    return {
        f"tester.{name}": np.concatenate([block.channels[name] for block in blocks])
        for name in CHANNELS
    }
