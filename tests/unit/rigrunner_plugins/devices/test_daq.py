"""The daq device: with the real library and no driver, and with a fake driver below it.

Arguments of driver calls are compared with the numbers of NI's header NIDAQmx.h.
"""

from __future__ import annotations

import threading
from pathlib import Path

import nidaqmx.utils
import numpy as np
import pytest
from nidaqmx.error_codes import DAQmxErrors

from rigrunner.api.devices import Approaching, DeviceContext, KnowsStream, Readable, Streaming
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    MissingPackageError,
)
from rigrunner.clock import SimulatedClock
from rigrunner.engine.streams import checked_stream
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.yamlfile import parse, validate
from rigrunner_plugins.devices.daq import daqmx
from rigrunner_plugins.devices.daq.settings import DaqSettings
from unit.rigrunner_plugins.devices.helpers_daqmx import FakeDriver

# NIDAQmx.h
NEWTON_METERS, FULL_BRIDGE, INTERNAL, MILLIVOLTS_PER_VOLT = 15881, 10182, 10200, 15897
RADIANS, X4, A_HIGH_B_HIGH = 10273, 10092, 10040
CONTINUOUS, RISING, DIFFERENTIAL, VOLTS = 10123, 10280, 10106, 10348
ON_DEMAND_NOW = -200284  # DAQmxErrorSamplesNotYetAvailable
OVERWRITTEN = -200279  # DAQmxErrorSamplesNoLongerAvailable
REMOVED = -200045  # DAQmxErrorDeviceRemoved
NO_DEVICE = -200220  # DAQmxErrorInvalidDeviceID
RESERVED = -50103  # DAQmxErrorPALResourceReserved

SETTINGS = {
    "device": "cDAQ1",
    "rate": "10 kHz",
    "channels": {
        "torque": {
            "kind": "torque",
            "source": "cDAQ1Mod1/ai0",
            "range": "10 N·m",
            "points": [{"ratio": "2 mV/V", "torque": "10 N·m"}],
        },
        "angle": {"kind": "encoder", "source": "cDAQ1/ctr0", "pulses": 3600, "scale": -1},
        "load": {
            "kind": "voltage",
            "source": "cDAQ1Mod2/ai3",
            "unit": "N",
            "scale": 200,
            "terminal": "differential",
        },
    },
    "drives": {
        "frequency": {
            "kind": "voltage",
            "source": "cDAQ1Mod3/ao0",
            "unit": "Hz",
            "scale": 5,
            "min": "0 Hz",
            "max": "35 Hz",
            "safe": "0 Hz",
            "sets_cycle_frequency": True,
        },
        "enable": {
            "kind": "digital",
            "source": "cDAQ1Mod4/port0/line2",
            "unit": "1",
            "min": "0 1",
            "max": "1 1",
            "safe": "0 1",
        },
    },
}
SIGNALS = {
    "torque": lambda t: np.sin(2 * np.pi * 10 * t),
    "angle": lambda t: 0.04 * np.cos(2 * np.pi * 10 * t),
    "load": lambda t: np.full(len(t), 5.0),
}


def settings(**changes):
    return {**SETTINGS, **changes}


@pytest.fixture
def clock():
    return SimulatedClock()


@pytest.fixture
def bench(clock, monkeypatch):
    """Return a function that makes a connected device on a fake driver."""

    def make_device(changes=None, *, connect=True, **of_driver):
        driver = FakeDriver(clock, SIGNALS, **of_driver)
        monkeypatch.setattr(
            nidaqmx.utils, "_select_interpreter", lambda *_a, **_k: driver.interpreter()
        )
        context = DeviceContext("tester", clock, Path())
        device = load_registry().make_device("daq", settings(**changes or {}), context)
        opened.append(device)
        if connect:
            device.connect(1.0)
        return device, driver

    opened = []
    yield make_device
    for device in opened:
        device.close()


def test_missing_driver_is_reported_with_a_clear_message(clock):
    device = load_registry().make_device("daq", SETTINGS, DeviceContext("tester", clock, Path()))
    with pytest.raises(DeviceNotFoundError) as raised:
        device.connect(1.0)
    assert "look for cDAQ1: Could not find an installation of NI-DAQmx" in str(raised.value)
    assert "install NI-DAQmx from ni.com" in raised.value.hint
    device.close()


def test_missing_package_names_the_extra(clock, monkeypatch):
    device = load_registry().make_device("daq", SETTINGS, DeviceContext("tester", clock, Path()))
    monkeypatch.setitem(__import__("sys").modules, "nidaqmx.constants", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'rigrunner\[daq\]'"):
        device.connect(1.0)


def test_daq_has_the_abilities_and_units_of_a_tester(bench):
    device, _ = bench(connect=False)
    for ability in (Readable, Approaching, Streaming, KnowsStream):
        assert isinstance(device, ability)
    assert [(c.name, c.unit) for c in device.channels] == [
        ("torque", "N·m"),
        ("angle", "rad"),
        ("load", "N"),
    ]
    assert not device.non_blocking


def test_identity_is_read_and_another_device_is_refused(bench):
    identity = bench()[0].connect(1.0)
    assert (identity.maker, identity.model) == ("National Instruments", "NI 9237")
    assert (identity.serial, identity.firmware) == ("1A2B3C4", "NI-DAQmx 26.0.0")
    assert not identity.simulated
    bench({"expect": {"model": "NI 9237", "serial": "1a2b3c4"}})
    with pytest.raises(DeviceNotFoundError, match="has the serial '1A2B3C4', expected '99'"):
        bench({"expect": {"serial": "99"}})


def test_bridge_is_set_up_from_its_certificate(bench):
    """Arguments of DAQmxCreateAITorqueBridgeTwoPointLinChan, in its order."""
    _, driver = bench()
    (_, *arguments), *_ = driver.called("create_ai_torque_bridge_two_point_lin_chan")
    assert arguments == [
        "cDAQ1Mod1/ai0", "torque", -10.0, 10.0, NEWTON_METERS, FULL_BRIDGE, INTERNAL, 2.5, 350.0,
        0.0, 2.0, MILLIVOLTS_PER_VOLT, 0.0, 10.0, NEWTON_METERS, "",
    ]  # fmt: skip


def test_bridge_table_is_sorted(bench):
    points = [
        {"ratio": "1.001 mV/V", "torque": "5 N·m"},
        {"ratio": "-2 mV/V", "torque": "-10 N·m"},
        {"ratio": "2.003 mV/V", "torque": "10 N·m"},
    ]
    torque = {**SETTINGS["channels"]["torque"], "points": points}
    _, driver = bench({"channels": {**SETTINGS["channels"], "torque": torque}})
    (arguments,) = driver.called("create_ai_torque_bridge_table_chan")[:1]
    ratios, units, torques = arguments[10], arguments[11], arguments[12]
    assert list(ratios) == pytest.approx([-2.0, 1.001, 2.003])
    assert units == MILLIVOLTS_PER_VOLT
    assert list(torques) == [-10.0, 5.0, 10.0]


def test_encoder_counts_at_the_analogue_sample_clock(bench):
    """Arguments of DAQmxCreateCIAngEncoderChan and DAQmxCfgSampClkTiming, in their order."""
    _, driver = bench()
    (_, *encoder), *_ = driver.called("create_ci_ang_encoder_chan")
    assert encoder == [
        "cDAQ1/ctr0", "angle", X4, False, 0.0, A_HIGH_B_HIGH, RADIANS, 3600, 0.0, "",
    ]  # fmt: skip
    timings = {task.channels[0]: args for task, *args in driver.called("cfg_samp_clk_timing")}
    assert timings["torque"] == [10_000.0, "", RISING, CONTINUOUS, 100_000]
    assert timings["angle"] == [10_000.0, "/cDAQ1/ai/SampleClock", RISING, CONTINUOUS, 100_000]


def test_voltage_input_has_its_range_and_wiring(bench):
    _, driver = bench()
    (_, *voltage), *_ = driver.called("create_ai_voltage_chan")
    assert voltage == ["cDAQ1Mod2/ai3", "load", DIFFERENTIAL, -10.0, 10.0, VOLTS, ""]


def test_torque_and_angle_are_sampled_at_the_same_edges(bench):
    device, driver = bench()
    driver.calls.clear()
    blocks = list(device.stream(["angle", "torque"], 0.55, threading.Event()))
    assert [block.first_sample for block in blocks] == [0, 1000, 2000, 3000, 4000, 5000]
    assert [block.samples for block in blocks] == [1000] * 5 + [500]
    time_s = np.arange(5500) / 10_000
    torque = np.concatenate([block.channels["torque"] for block in blocks])
    angle = np.concatenate([block.channels["angle"] for block in blocks])
    assert torque == pytest.approx(SIGNALS["torque"](time_s))
    assert angle == pytest.approx(-SIGNALS["angle"](time_s))
    start_order = [task.channels[0] for (task,) in driver.called("start_task")]
    assert start_order == ["angle", "torque"]  # or the counter misses the first edges
    assert len(driver.called("clear_task")) == 2


def test_voltage_is_scaled_to_its_quantity(bench):
    device, _ = bench()
    assert device.read(["load"])["load"] == pytest.approx(1000.0)  # 5 V at 200 N/V


def test_reading_during_a_recording_is_of_the_newest_block(bench):
    device, driver = bench()
    blocks = device.stream(["torque"], 1.0, threading.Event())
    next(blocks)
    before = len(driver.called("create_task"))
    assert device.read(["load"])["load"] == pytest.approx(1000.0)
    assert len(driver.called("create_task")) == before
    blocks.close()
    assert driver.open_tasks == 2  # the two outputs


def test_stop_ends_the_acquisition(bench):
    device, driver = bench()
    stop = threading.Event()
    blocks = device.stream(["torque"], 5.0, stop)
    next(blocks)
    stop.set()
    assert list(blocks) == []
    assert driver.open_tasks == 2


def test_filter_is_recorded_if_the_device_has_one(bench):
    device, _ = bench()
    assert device.stream_conditions() == {
        "torque_filter_delay": (0.0031, "s"),
        "torque_filter_corner": (4530.0, "Hz"),
        "load_filter_delay": (0.0031, "s"),
        "load_filter_corner": (4530.0, "Hz"),
    }
    assert bench(filters=False)[0].stream_conditions() == {}


def test_filter_delay_can_be_removed(bench):
    _, driver = bench({"remove_filter_delay": True})
    calls = driver.called("set_chan_attribute_bool")
    assert {(channel, *rest) for _, channel, *rest in calls} == {
        ("torque", 0x2FBD, True),  # DAQmx_AI_RemoveFilterDelay
        ("load", 0x2FBD, True),
    }


def test_sample_rate_other_than_the_station_s_is_refused(bench):
    with pytest.raises(DeviceRejectedError) as raised:
        bench(coerced_hz=10_240.0)
    assert "cannot sample at 10000 Hz: the nearest rate is 10240.000000 Hz" in str(raised.value)
    assert "rate: 10240.0 Hz" in raised.value.hint


def test_outputs_are_set_and_read_back(bench):
    device, driver = bench()
    device.set("frequency", 20.0)
    assert driver.outputs["frequency"] == pytest.approx(4.0)  # 20 Hz at 5 Hz/V
    assert device.read_back("frequency") == 20.0
    (_, *output), *_ = driver.called("create_ao_voltage_chan")
    assert output[:4] == ["cDAQ1Mod3/ao0", "frequency", 0.0, 7.0]
    device.set("enable", 1.0)
    assert driver.outputs["enable"] == 1.0
    assert device.read_back("enable") == 1.0
    with pytest.raises(DeviceRejectedError, match=r"is a line and cannot be set to 0\.5"):
        device.set("enable", 0.5)
    assert device.make_safe() == {"frequency": 0.0, "enable": 0.0}
    assert driver.outputs == {"frequency": 0.0, "enable": 0.0}


def test_drive_measured_by_a_channel_is_read_back_from_it(bench):
    drives = {
        "load": {
            "kind": "voltage", "source": "cDAQ1Mod3/ao1", "unit": "N", "scale": 500,
            "min": "0 N", "max": "3000 N", "safe": "0 N", "read_back": "load", "settle": "0 s",
        }
    }  # fmt: skip
    device, driver = bench({"drives": drives})
    device.set("load", 1000.0)
    with pytest.raises(DeviceTimeoutError, match="load reads back 1000 N after 0 s, set to 2000 N"):
        device.set("load", 2000.0)
    assert driver.outputs["load"] == 4.0


def test_drive_that_was_never_set_has_no_read_back(bench):
    device, _ = bench()
    with pytest.raises(DeviceRejectedError, match="was not set since the connection was opened"):
        device.read_back("frequency")


@pytest.mark.parametrize(
    ("failure", "kind", "message"),
    [
        (("read_analog_f64", OVERWRITTEN), DeviceLostError, "samples were lost, they came faster"),
        (("read_analog_f64", REMOVED), DeviceLostError, "is it plugged in"),
        (("read_counter_f64_ex", ON_DEMAND_NOW), DeviceTimeoutError, "does the sample clock run"),
        (("start_task", RESERVED), DeviceRejectedError, "close the program that uses it"),
    ],
)
def test_failures_during_a_recording_are_reported_and_release_the_device(
    bench, clock, failure, kind, message
):
    call, code = failure
    device, driver = bench()
    driver.fails[call] = code
    with pytest.raises(kind, match=message):
        list(device.stream(["torque", "angle"], 1.0, threading.Event()))
    assert driver.open_tasks == 2
    del driver.fails[call]
    rig = Rig({"tester": device}, clock)
    rig._connected.add("tester")
    assert [report.safe for report in rig.make_safe()] == [True]
    rig.close()
    assert driver.open_tasks == 0


def test_missing_device_leaves_no_task_open(bench):
    device, driver = bench(connect=False, fails={"create_ai_voltage_chan": NO_DEVICE})
    with pytest.raises(DeviceNotFoundError, match="this name in NI MAX"):
        device.connect(1.0)
    assert driver.open_tasks == 0


def test_outputs_that_cannot_be_written_are_not_safe(bench, clock):
    device, driver = bench()
    device.set("frequency", 10.0)
    driver.fails["write_analog_f64"] = REMOVED
    rig = Rig({"tester": device}, clock)
    rig._connected.add("tester")
    (report,) = rig.make_safe()
    assert not report.safe
    assert "make safe failed" in report.problems[0]
    assert driver.outputs["frequency"] == 2.0
    rig.close()


def test_engine_accepts_its_stream(bench, clock):
    device, _ = bench()
    rig = Rig({"tester": device}, clock)
    rig._connected.add("tester")

    class Session:
        stop = threading.Event()
        drives = None

        class guard:  # noqa: N801
            feed = staticmethod(lambda *_: None)

        check = staticmethod(lambda: None)

    Session.rig = rig
    blocks = list(checked_stream(Session, "tester", ["angle", "torque"], 0.5))
    assert sum(block.samples for block in blocks) == 5000
    rig.close()


def test_names_of_its_errors_are_those_of_the_library():
    names = {code.name for code in DAQmxErrors}
    for group in (daqmx.NOT_THERE, daqmx.OVERRUN, daqmx.LATE, daqmx.TAKEN):
        assert group <= names


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("channels",), {"angle": SETTINGS["channels"]["angle"]}, "follows the sample clock"),
        (("channels", "torque", "source"), "ai0", "pattern"),
        (("channels", "torque", "range"), "10 N", "is a force, not a torque"),
        (("channels", "torque", "points"), [], "at least 1 item"),
        (("channels", "torque", "kind"), "strain", "'torque', 'voltage', 'encoder'"),
        (
            ("channels", "torque", "points"),
            [{"ratio": "2 mV/V", "torque": "10 N·m"}, {"ratio": "2 mV/V", "torque": "20 N·m"}],
            "must always rise, or always fall",
        ),
        (("channels", "load", "low"), "20 V", "expected low < high"),
        (("drives", "frequency", "read_back"), "speed", "no channel 'speed'"),
    ],
)
def test_contradictory_settings_are_refused(path, value, message):
    changed = {
        key: dict(part) if isinstance(part, dict) else part for key, part in SETTINGS.items()
    }
    inner = changed
    for key in path[:-1]:
        inner[key] = dict(inner[key])
        inner = inner[key]
    inner[path[-1]] = value
    with pytest.raises(ValueError, match=message):
        DaqSettings.model_validate(changed)


def test_station_of_the_manual_is_valid():
    page = Path(__file__).parents[4] / "docs" / "how-to" / "national-instruments.md"
    text = page.read_text(encoding="utf-8").partition("```yaml\n")[2].partition("```")[0]
    document = parse(text, str(page))
    settings_ = validate(DaqSettings, document, ("devices", "tester", "settings"))
    assert settings_.rate == 10_240.0
    assert settings_.counter_clock == "/cDAQ1/ai/SampleClock"
    assert settings_.channels["torque"].table == ((0.0, 0.0), (pytest.approx(2.0015), 10.0))
