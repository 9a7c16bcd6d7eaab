"""The shipped procedures on a National Instruments station: the real library, no driver below it.

The fake driver is fed by the rig's model. This shows that the channels, their scales and their
common clock are right at the other end; it cannot show what a real driver and device do.
"""

from __future__ import annotations

from datetime import UTC, datetime

import nidaqmx.utils
import numpy as np
import pytest

from helpers_rigs import make_rig, true_starting_torque_nm
from helpers_workflow import quick_procedure, run, station_file
from rigrunner.api.errors import DeviceLostError
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import read
from rigrunner_bearings.devices.simulated.sampling import (
    RigState,
    noise_source,
    rig_source,
    sample_channels,
)
from rigrunner_bearings.devices.simulated.sensor_errors import draw_constant_errors
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_plugins.devices.helpers_daqmx import FakeDriver

START = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
HZ_PER_V, N_PER_V = 5.0, 300.0
LONGEST_S = 12.0
PLAIN = """\
    plugin: swing_tester_sim
    settings: {seed: 1}
"""
DAQ = f"""\
    plugin: daq
    settings:
      device: cDAQ1
      rate: 10 kHz
      channels:
        torque:
          kind: torque
          source: cDAQ1Mod1/ai0
          range: 12 N·m
          points: [{{ratio: 2 mV/V, torque: 10 N·m}}]
        angle: {{kind: encoder, source: cDAQ1/ctr0, pulses: 9000, scale: -1}}
        load: {{kind: voltage, source: cDAQ1Mod2/ai0, unit: N, scale: {N_PER_V:g}}}
        temperature: {{kind: voltage, source: cDAQ1Mod2/ai1, unit: °C, scale: 10}}
      drives:
        frequency: {{kind: voltage, source: cDAQ1Mod3/ao0, unit: Hz, scale: {HZ_PER_V:g},
                    min: 0 Hz, max: 35 Hz, safe: 0 Hz, sets_cycle_frequency: yes}}
        load: {{kind: voltage, source: cDAQ1Mod3/ao1, unit: N, scale: {N_PER_V:g},
               min: 0 N, max: 3000 N, safe: 0 N, tolerance: 20 N, read_back: load}}
"""
SIMULATED, TRIAL = "    calibration: simulated  ", "    calibration: trial  "
REST = """\
  - {channel: tester.angle, measures: angle, serial: E-1, calibration: trial, accuracy: 0.01 deg}
  - {channel: tester.load, measures: force, serial: L-1, calibration: trial, accuracy: 3 N}
"""


class Model:
    """The rig as seen by the driver's inputs and driven by its outputs."""

    def __init__(self, clock):
        self.rig = make_rig(RigParameters())
        self.errors = draw_constant_errors(self.rig.sensors, rig_source(1))
        self.clock, self.repetition, self.now = clock, 0, {}
        self.driver = FakeDriver(clock, {name: self._of(name) for name in CHANNELS})

    def _state(self):
        outputs = self.driver.outputs
        hertz = HZ_PER_V * outputs.get("frequency", 0.0)
        return RigState(hertz, N_PER_V * outputs.get("load", 0.0), self.clock.monotonic_s())

    def _of(self, name):
        def sampled(time_s):
            if name == "torque" and time_s[0] == 0:
                self._begin()
            first = round(time_s[0] * self.rig.sensors.sample_rate_hz)
            return self.now[name][first : first + len(time_s)]

        return sampled

    def _begin(self):
        state, count = self._state(), round(LONGEST_S * self.rig.sensors.sample_rate_hz)
        self.repetition += 1
        rng = noise_source(1, state, self.repetition)
        samples = sample_channels(self.rig, state, count, self.errors, rng)
        self.now = {
            "torque": samples["torque"],
            "angle": -samples["angle"],
            "load": np.full(count, state.load_n / N_PER_V),
            "temperature": np.full(count, 2.3),
        }


CHANNELS = ("torque", "angle", "load", "temperature")


@pytest.fixture
def clock():
    return SimulatedClock(START)


@pytest.fixture
def model(clock, monkeypatch):
    made = Model(clock)
    monkeypatch.setattr(
        nidaqmx.utils, "_select_interpreter", lambda *_a, **_k: made.driver.interpreter()
    )
    return made


@pytest.fixture
def station(tmp_path):
    path = station_file(tmp_path, (PLAIN, DAQ), (SIMULATED, TRIAL))
    path.write_text(path.read_text(encoding="utf-8").rstrip() + "\n" + REST, encoding="utf-8")
    return path


@pytest.mark.thorough
def test_procedures_give_the_true_result(tmp_path, clock, model, station):
    no_load = quick_procedure(tmp_path, "no_load_inertia_sweep")
    bare = run(no_load, tmp_path / "runs", station=station, clock=clock)
    assert bare.error is None
    loaded = quick_procedure(tmp_path, "starting_torque_1000n")
    done = run(loaded, tmp_path / "runs", station=station, clock=clock, no_load=bare.folder)
    assert done.error is None
    truth = true_starting_torque_nm(RigParameters(), 1000.0, 20.0)
    assert abs(done.result.headline.value - truth) < 2 * done.result.headline.u
    stored = read(done.folder)
    recording = stored.recordings[0]
    assert recording.conditions["tester.torque_filter_delay"] == pytest.approx(0.0031)
    assert recording.units["tester.torque_filter_corner"] == "Hz"
    assert recording.conditions["tester.temperature"] == pytest.approx(273.15 + 23)
    assert "tester.angle_alignment_u" not in recording.conditions  # one clock
    assert "NI 9237 1A2B3C4 NI-DAQmx 26.0.0" in stored.header.provenance["device tester"]
    assert model.driver.outputs == {"frequency": 0.0, "load": 0.0}
    assert model.driver.open_tasks == 0


def test_lost_samples_end_the_run_safely(tmp_path, clock, model, station):
    procedure = quick_procedure(tmp_path, "no_load_inertia_sweep")
    plain, reads = model._begin, []

    def failing():
        reads.append(model.driver.outputs.get("frequency", 0.0))
        if reads[-1] > 0:
            model.driver.fails["read_counter_f64_ex"] = -200279  # SamplesNoLongerAvailable
        plain()

    model._begin = failing
    done = run(procedure, tmp_path / "runs", station=station, clock=clock)
    assert isinstance(done.error, DeviceLostError)
    assert "tester: read: samples were lost, they came faster than they were read" in str(
        done.error
    )
    assert model.driver.outputs["frequency"] == 0.0
    log = (done.folder / "run.log").read_text(encoding="utf-8")
    assert "safe" in log
