from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner.api.devices import DeviceContext, KnowsTruth
from rigrunner.api.errors import DeviceNotFoundError
from rigrunner.clock import SimulatedClock
from rigrunner_bearings.devices.simulated.parameters import DEG_RAD
from rigrunner_bearings.devices.swing_tester_ode import device as ode
from rigrunner_bearings.devices.swing_tester_ode.parameters import OdeParameters
from rigrunner_bearings.devices.swing_tester_ode.settings import SwingTesterOdeSettings
from rigrunner_bearings.devices.swing_tester_sim import device as sim
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from rigrunner_bearings.devices.swing_tester_sim.settings import SwingTesterSimSettings

MODELS = {"sim": (SwingTesterSimSettings, sim.make), "ode": (SwingTesterOdeSettings, ode.make)}
PERFECT = {
    "noise": "0 N·m", "spike_probability": "0 %", "gain": "0 %", "offset": "0 N·m",
    "drift": "0 N·m", "nonlinearity": "0 %", "bits": 24, "encoder_resolution": "0 deg",
}  # fmt: skip


class Never:
    def is_set(self):
        return False


@pytest.fixture(params=MODELS)
def model(request):
    return request.param


def connect(model="sim", **settings):
    model_type, make = MODELS[model]
    context = DeviceContext("tester", SimulatedClock(), Path())
    device = make(model_type.model_validate({"seed": 3} | settings), context)
    device.connect(1.0)
    return device


def record(device, frequency=20.0, load=1000.0, seconds=0.5, channel="torque", *, beside=()):
    device.set("load", load)
    device.set("frequency", frequency)
    blocks = list(device.stream([channel, *beside], seconds, Never()))
    return np.concatenate([block.channels[channel] for block in blocks])


def test_default_settings_equal_default_parameters():
    assert SwingTesterSimSettings().parameters() == RigParameters()
    assert SwingTesterOdeSettings().parameters() == OdeParameters()


@pytest.mark.parametrize(
    "wrong",
    [
        {"seed": -1},
        {"seed": "1"},
        {"simulate": "broken"},
        {"eccentric": "45 mm"},
        {"max_frequency": 35.0},
        {"sensors": {"rate": "0 Hz"}},
        {"sensors": {"noise": "0.02 Hz"}},
        {"sensors": {"nois": "0.02 N·m"}},
    ],
)
def test_invalid_settings_are_refused(model, wrong):
    with pytest.raises(ValidationError):
        MODELS[model][0].model_validate(wrong)


def test_unplugged_device_is_not_found(model):
    with pytest.raises(DeviceNotFoundError, match=r"no swing_tester_\w+ answered within 1 s"):
        connect(model, simulate="unplugged")


def test_same_seed_records_same_samples(model):
    assert np.array_equal(record(connect(model)), record(connect(model)))


def test_another_seed_gives_another_rig(model):
    first, second = connect(model), connect(model, seed=4)
    assert not np.array_equal(record(first), record(second))
    at_rest = [record(device, 0.0, 0.0, 2.0).mean() for device in (first, second)]
    assert abs(at_rest[0] - at_rest[1]) > 1e-3
    assert max(map(abs, at_rest)) < 0.02 + 0.001


def test_noise_does_not_depend_on_earlier_recordings():
    steady = {"sensors": {"drift": "0 N·m"}}
    alone, after = connect(**steady), connect(**steady)
    record(after, 35.0)
    record(after, 20.0, 500.0)
    after.set("load", 1000.0)
    after.read(["torque", "load"])
    assert np.array_equal(record(alone), record(after))


def test_repeated_recording_has_new_noise():
    device = connect()
    first, second = record(device), record(device)
    assert not np.array_equal(first, second)
    device.connect(1.0)
    assert np.abs(record(device) - first).max() < 0.02  # the drift alone


CHANNELS = ["torque", "angle", "velocity", "index", "load", "temperature", "humidity"]


@pytest.mark.parametrize("channel", CHANNELS)
def test_channel_does_not_depend_on_other_recorded_channels(channel):
    beside = [name for name in CHANNELS if name != channel]
    alone = record(connect(), channel=channel)
    assert np.ptp(alone) > 0
    np.testing.assert_array_equal(alone, record(connect(), channel=channel, beside=beside))


def test_resumed_run_has_noise_of_uninterrupted_run():
    uninterrupted, resumed = (
        connect(sensors={"drift": "0 N·m"}),
        connect(sensors={"drift": "0 N·m"}),
    )
    for _ in range(2):
        record(uninterrupted)
    resumed.continue_after([{"frequency": 20.0, "load": 1000.0}] * 2)
    assert np.array_equal(record(uninterrupted), record(resumed))


def test_zero_drifts_over_time_of_setup():
    device = connect(sensors={"noise": "0 N·m", "spike_probability": "0 %", "drift": "1 N·m"})
    shown = []
    for _ in range(3):
        shown.append(record(device, 0.0, 0.0, 0.1).mean())
        device._clock.sleep(1800.0)
    first, second = np.diff(np.abs(np.array(shown) - shown[0]))
    assert first > 10 * abs(second) > 0  # three time constants, then three more
    device.connect(1.0)
    assert record(device, 0.0, 0.0, 0.1).mean() == pytest.approx(shown[0], abs=2e-3)


def test_torque_at_rest_is_offset_drift_and_noise(model):
    device = connect(model)
    torque = record(device, 0.0, 0.0, 1.0)
    assert abs(torque.mean()) < 0.045
    assert torque.std() == pytest.approx(0.02, rel=0.1)
    assert device.truth() == {}


def test_device_knows_truth_of_last_stream(model):
    device = connect(model, frequency_error="10 %")
    assert isinstance(device, KnowsTruth)
    record(device, 20.0, 500.0)
    truth = device.truth()
    assert truth["starting_torque_nm"] == pytest.approx(0.3631, abs=1e-4)
    assert truth["frequency_hz"] == pytest.approx(22.0)
    assert {"inertia_kgm2", "natural_frequency_hz", "damping_ratio"} <= set(truth)


def test_truth_is_not_a_channel(model):
    device = connect(model)
    assert {info.name for info in device.channels} == {
        "angle", "torque", "velocity", "index", "load", "temperature", "humidity",
    }  # fmt: skip


def test_conditions_can_be_read_while_rig_swings():
    device = connect()
    device.set("load", 1000.0)
    device.set("frequency", 10.0)
    values = device.read(["load", "temperature", "humidity"])
    assert values["load"] == pytest.approx(1000, abs=5)
    assert values["temperature"] == pytest.approx(296.15, abs=0.5)
    assert 0 < values["humidity"] < 1


def test_full_load_clips_narrow_range():
    torque = record(connect(sensors={"range": "4 N·m"}), 35.0)
    assert torque.min() == -4.0
    assert (torque == torque.max()).sum() > 3


COMMON_FAULTS = [
    {"sensors": {"torque_delay": "1 ms"}},
    {"sensors": {"encoder_noise": "0.003 deg"}},
    {"sensors": {"encoder_resolution": "0.02 deg"}},
    {"sensors": {"low_pass": "200 Hz"}},
    {"sensors": {"gain": "3 %"}},
    {"sensors": {"offset": "0.2 N·m"}},
    {"sensors": {"drift": "2 N·m"}},
    {"sensors": {"nonlinearity": "1 %"}},
    {"sensors": {"noise": "0.1 N·m"}},
    {"sensors": {"spike_probability": "1 %"}},
    {"sensors": {"bits": 8}},
    {"speed_jitter": "0.05 %"},
    {"frequency_error": "5 %"},
    {"eccentric": "2.1 mm"},
]
SIM_FAULTS = [
    {"drive_line": {"inertia_change_under_load": "1 %"}},
    {"drive_line": {"natural_frequency": "300 Hz"}},
    {"drive_line": {"damping_ratio": "10 %"}},
    {"support": {"growth_per_kilonewton": "5 %"}},
    {"bearing": {"zero_load_torque": "0.1 N·m"}},
    {"bearing": {"asymmetry": "0.1 N·m"}},
    {"bearing": {"weakening": "speed"}},
]


@pytest.mark.parametrize(
    ("model", "fault"),
    [(model, fault) for model in MODELS for fault in COMMON_FAULTS]
    + [("sim", fault) for fault in SIM_FAULTS],
    ids=str,
)
def test_every_fault_changes_the_recording(model, fault):
    healthy, broken = connect(model), connect(model, **fault)
    same = all(
        np.array_equal(record(healthy, channel=name), record(broken, channel=name))
        for name in ("angle", "torque")
    )
    assert not same


@pytest.mark.parametrize(
    "fault",
    [
        {"drive_line": {"inertia_change_under_load": "1 %"}},
        {"support": {"growth_per_kilonewton": "5 %"}},
        {"bearing": {"asymmetry": "0.1 N·m"}},
    ],
    ids=str,
)
def test_faults_under_load_do_not_show_without_load(fault):
    assert np.array_equal(record(connect(), load=0.0), record(connect(**fault), load=0.0))


def test_fault_sizes_are_as_set():
    def mean(**settings):
        return record(connect(sensors=PERFECT, **settings), 20.0, 1000.0, 1.0)

    healthy = mean()
    asymmetric = mean(bearing={"asymmetry": "0.1 N·m"})
    assert asymmetric - healthy == pytest.approx(np.full(10_000, 0.1), abs=1e-5)
    grown = mean(support={"growth_per_kilonewton": "5 %"})
    assert np.abs(grown - healthy).max() == pytest.approx(0.05 * 0.7597, rel=0.3)
    angle = record(connect(sensors=PERFECT | {"encoder_noise": "0.003 deg"}), channel="angle")
    exact = record(connect(sensors=PERFECT), channel="angle")
    assert (angle - exact).std() == pytest.approx(0.003 * DEG_RAD, rel=0.05)
