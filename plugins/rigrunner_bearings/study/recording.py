"""Records both runs of a study's rig in memory, in simulated time.

Through the device plugin and the stream checks of the engine, which refuse the same recordings.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api import DeviceContext, Recording, RunData
from rigrunner.bus import Bus, Emitter
from rigrunner.clock import SimulatedClock, utc_text
from rigrunner.engine import UnattendedAnswers
from rigrunner.engine.interlocks import Guard
from rigrunner.engine.session import Session
from rigrunner.engine.streams import checked_stream
from rigrunner.rig import Rig
from rigrunner_bearings.api.rig import torque_instruments
from rigrunner_bearings.study.bench import LOAD_N, nested
from rigrunner_bearings.torque.settings import NO_LOAD, NO_LOAD_AFTER

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api import Array
    from rigrunner.registry import Registry
    from rigrunner.station import Station
    from rigrunner_bearings.study.bench import Bench, BenchSettings

SETTLE_CYCLES = 5
MARGIN_CYCLES = 1.0
"""Recorded in addition to the required cycles, as the first one begins anywhere."""

ZERO_S = 1.0
ROLE = "tester"
ANGLE, TORQUE = "tester.angle", "tester.torque"
UNITS = {ANGLE: "rad", TORQUE: "N·m", "tester.frequency": "Hz", "tester.load": "N"}


@dataclass(frozen=True, eq=False)
class RecordedBench:
    """Both runs, and the true values of the loaded one."""

    no_load: RunData
    loaded: RunData
    truths_nm: tuple[float, ...]
    """The load-induced starting torque at each set-point."""
    no_load_after: RunData | None = None
    """A second no-load run, after the loaded one."""

    @property
    def loaded_with_partners(self) -> RunData:
        """The loaded run with its partner runs."""
        runs = {NO_LOAD: self.no_load, NO_LOAD_AFTER: self.no_load_after}
        partners = {name: run for name, run in runs.items() if run is not None}
        return replace(self.loaded, partners=partners)

    @property
    def truth_nm(self) -> float:
        """The mean of the truths over the set-points."""
        return float(np.mean(self.truths_nm))


@dataclass(frozen=True)
class Faults:
    """The faults of each of the two runs, as settings of the plugin `fault`."""

    no_load: tuple[Mapping[str, Any], ...] = ()
    loaded: tuple[Mapping[str, Any], ...] = ()
    seed: int = 0


NO_FAULTS = Faults()


@dataclass(frozen=True, eq=False)
class _Setup:
    """A connected device, with its clock, rig and station."""

    device: Any
    clock: SimulatedClock
    bench: Bench
    station: Station

    @property
    def session(self) -> Session:
        """A session of the engine for streams, without listeners."""
        rig = Rig({ROLE: self.device}, self.clock)
        emit = Emitter(Bus((), ()), self.clock)
        return Session(rig, emit, UnattendedAnswers(), threading.Event(), Guard((), rig, emit))


def record_bench(
    bench: Bench, registry: Registry, station: Station, faults: Faults = NO_FAULTS
) -> RecordedBench:
    """Do the no-load run, wait, and do the loaded run, in one set-up, so that the zero drifts on.

    Raises the DeviceError with which the engine refuses a recording.
    """
    clock = SimulatedClock()
    device = _device(bench, bench.no_load, faults.no_load, faults.seed, registry, clock)
    no_load_setup = _Setup(device, clock, bench, station)
    loaded_setup = no_load_setup
    if bench.loaded != bench.no_load or faults.loaded != faults.no_load:
        # Connected before the first run: its zero drifts from then on, like that of the first.
        device = _device(bench, bench.loaded, faults.loaded, faults.seed, registry, clock)
        loaded_setup = replace(no_load_setup, device=device)
    no_load, _ = _run(no_load_setup, "no-load", bench.no_load_n, 0.0)
    clock.sleep(bench.pause_s)
    loaded, truths = _run(loaded_setup, "loaded", bench.load_n, LOAD_N)
    return RecordedBench(no_load, _shifted(loaded, bench), truths)


def _device(  # noqa: PLR0917  (the parts of a device)
    bench: Bench,
    settings: BenchSettings,
    faults: Sequence[Mapping[str, Any]],
    seed: int,
    registry: Registry,
    clock: SimulatedClock,
) -> Any:
    context = DeviceContext(ROLE, clock, Path())
    tree = nested(settings, bench.seed)
    device = registry.make_device(bench.simulator, tree, context)
    if faults:
        wrapped = {"plugin": bench.simulator, "settings": tree, "seed": seed, "faults": [*faults]}
        device = registry.make_device("fault", wrapped, context)
    device.connect(1.0)
    return device


def _run(
    setup: _Setup, name: str, actual_n: float, stated_n: float
) -> tuple[RunData, tuple[float, ...]]:
    """Return one run under the actual load with the stated one, and the truth of each set-point."""
    started = utc_text(setup.clock.utc())
    zero = float(np.mean(_streamed(setup, ZERO_S)[TORQUE]))
    setup.device.set("load", actual_n)
    pairs = [_recording(setup, frequency, stated_n) for frequency in setup.bench.frequencies_hz]
    setup.device.make_safe()
    reference = {"natural_frequency": f"{float(setup.bench.reference_hz)!r} Hz"}
    (instrument,) = torque_instruments(setup.station.instruments).values()
    run = RunData(
        run_id=f"{name}-{setup.bench.seed}",
        procedure_id=name,
        procedure_revision="",
        procedure_title=name,
        station_id=setup.station.id,
        started_utc=started,
        ended_utc=utc_text(setup.clock.utc()),
        outcome="completed",
        inputs={},
        rig_keys={**setup.station.rig, **reference},
        instruments={TORQUE: instrument},
        zeros={TORQUE: zero},
        recordings=tuple(recording for recording, _ in pairs),
    )
    return run, tuple(truth for _, truth in pairs)


def _recording(setup: _Setup, frequency_hz: float, load_n: float) -> tuple[Recording, float]:
    setup.device.set("frequency", frequency_hz)
    setup.clock.sleep(SETTLE_CYCLES / frequency_hz)
    channels = _streamed(setup, (setup.bench.cycles + MARGIN_CYCLES) / frequency_hz)
    recording = Recording(
        name=f"{frequency_hz:g} Hz",
        rate_hz=setup.device.sample_rate_hz,
        started_utc=utc_text(setup.clock.utc()),
        setpoints={"tester.frequency": frequency_hz, "tester.load": load_n},
        channels=channels,
        units=UNITS,
        conditions={"tester.load": load_n},
    )
    return recording, setup.device.truth()["starting_torque_nm"]


def _streamed(setup: _Setup, duration_s: float) -> dict[str, Array]:
    blocks = list(checked_stream(setup.session, ROLE, ("angle", "torque"), duration_s))
    return {
        name: np.concatenate([block.channels[name] for block in blocks]) for name in (ANGLE, TORQUE)
    }


def _shifted(run: RunData, bench: Bench) -> RunData:
    """Return the loaded run with the zero shift and the torques that come with its load."""
    recordings = []
    for recording in run.recordings:
        angle = np.asarray(recording.channels[ANGLE])
        spring = bench.spring_nm * angle / np.abs(angle).max()
        shift = bench.zero_shift_nm + bench.one_sided_nm
        torque = np.asarray(np.asarray(recording.channels[TORQUE]) + shift + spring)
        recordings.append(replace(recording, channels={**recording.channels, TORQUE: torque}))
    zeros = {TORQUE: run.zeros[TORQUE] + bench.zero_shift_nm}
    return replace(run, recordings=tuple(recordings), zeros=zeros)
