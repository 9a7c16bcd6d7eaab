"""The faulty device: each fault occurs where it is configured, and nowhere else."""

from __future__ import annotations

import threading
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from rigrunner.api.data import Block
from rigrunner.api.devices import (
    DeviceContext,
    Identity,
    KnowsTruth,
    Pausable,
    Readable,
    Settable,
    Streaming,
)
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.provenance import identities, is_simulated

REGISTRY = load_registry()
NAMES = ("angle", "torque")
STOP = threading.Event()


def faulty(*faults, plugin="swing_tester_sim", seed=5, connect=True):
    settings = {"plugin": plugin, "settings": {"seed": 3}, "seed": seed, "faults": list(faults)}
    context = DeviceContext("tester", SimulatedClock(), Path())
    device = REGISTRY.make_device("fault", settings, context)
    if connect:
        device.connect(1.0)
    return device


def stream(device, hz=10.0, seconds=1.0):
    device.set("frequency", hz)
    return list(device.stream(NAMES, seconds, STOP))


def torque(blocks):
    return np.concatenate([block.channels["torque"] for block in blocks])


def clean_torque(hz=10.0, seconds=1.0):
    return torque(stream(faulty(), hz, seconds))


def faulty_torque(**fault):
    return torque(stream(faulty(fault)))


def test_without_faults_it_equals_the_wrapped_device():
    context = DeviceContext("tester", SimulatedClock(), Path())
    wrapped = REGISTRY.make_device("swing_tester_sim", {"seed": 3}, context)
    wrapped.connect(1.0)
    device = faulty()
    assert [list(b.channels["torque"]) for b in stream(device)] == [
        list(b.channels["torque"]) for b in stream(wrapped)
    ]
    assert device.truth() == wrapped.truth()
    assert (device.channels, device.drives) == (wrapped.channels, wrapped.drives)


def test_it_has_only_the_abilities_of_the_wrapped_device():
    abilities = (Readable, Settable, Streaming, Pausable, KnowsTruth)
    assert all(isinstance(faulty(), ability) for ability in abilities)
    rows = [{"frequency": "1 Hz", "torque": "1 N·m"}, {"frequency": "2 Hz", "torque": "2 N·m"}]
    table = {"title": "T", "set_points": ["frequency"], "rows": rows}
    context = DeviceContext("tester", SimulatedClock(), Path())
    settings = {"plugin": "tabulated", "settings": table}
    wrapped = REGISTRY.make_device("fault", settings, context)
    assert isinstance(wrapped, Readable)
    assert not isinstance(wrapped, Streaming)


def test_device_with_faults_is_not_taken_for_a_real_one(monkeypatch):
    tester = type(faulty()._inner)
    real = Identity("Maker", "Rig", "1")
    monkeypatch.setattr(tester, "connect", lambda *_: real)
    assert faulty(connect=False).connect(1.0) == real
    identity = faulty({"kind": "nan"}, connect=False).connect(1.0)
    assert (identity.model, identity.simulated) == ("Rig with faults put in", True)
    assert is_simulated(identities({"tester": identity}))
    assert not is_simulated(identities({"tester": real}))


def test_complex_samples_of_the_wrapped_device_are_refused(monkeypatch):
    plain_init = Block.__init__

    def imaginary(self, rate_hz, first_sample, monotonic_s, channels):
        complex_channels = {name: values + 0.5j for name, values in channels.items()}
        plain_init(self, rate_hz, first_sample, monotonic_s, complex_channels)

    device = faulty({"kind": "noise", "channel": "torque", "extent": "0.1 N·m"})
    monkeypatch.setattr(Block, "__init__", imaginary)
    with pytest.raises(DeviceRejectedError, match="torque: the samples are complex128"):
        stream(device, seconds=0.1)


def test_share_of_the_samples_is_nan():
    assert np.isnan(faulty_torque(kind="nan")).sum() == 1
    assert np.isnan(faulty_torque(kind="nan", share="1 %")).sum() == 100


def test_spikes_have_the_configured_number_and_size():
    change = faulty_torque(kind="spikes", extent="3 N·m", share="0.5 %") - clean_torque()
    sizes = np.abs(change[change != 0])
    assert len(sizes) == 50
    assert sizes.min() >= 1.5
    assert sizes.max() <= 3.0


def test_stuck_value_lasts_for_its_share_of_the_recording_across_blocks():
    samples = faulty_torque(kind="stuck", share="30 %")
    equal = np.flatnonzero(np.diff(samples) == 0)
    changed = np.flatnonzero(samples != clean_torque())
    assert changed[-1] - changed[0] < 3000
    assert len(equal) >= 2990
    assert len(set(samples[changed])) == 1


def test_clipped_channel_ends_at_its_level():
    samples = faulty_torque(kind="clipped", extent="0.9 N·m")
    assert samples.max() == 0.9
    assert samples.min() == -0.9
    np.testing.assert_array_equal(samples, np.clip(clean_torque(), -0.9, 0.9))


def test_drift_reaches_its_extent_ten_minutes_after_connecting():
    device = faulty({"kind": "drift", "extent": "0.6 N·m"})
    device._clock.sleep(300.0)
    change = torque(stream(device, 0.0)) - torque(_after(faulty(), 300.0))
    np.testing.assert_allclose(change[[0, -1]], [0.3, 0.301], atol=1e-4)


def _after(device, seconds):
    device._clock.sleep(seconds)
    return stream(device, 0.0)


def test_noise_and_sensitivity_have_their_extent():
    clean = clean_torque()
    noise = faulty_torque(kind="noise", extent="0.2 N·m") - clean
    assert np.std(noise) == pytest.approx(0.2, rel=0.03)
    np.testing.assert_allclose(faulty_torque(kind="sensitivity", extent="2 %"), 1.02 * clean)


def test_block_is_dropped_repeated_or_out_of_order():
    firsts = {
        kind: [block.first_sample // 1000 for block in stream(faulty({"kind": kind}))]
        for kind in ("dropped blocks", "repeated block", "wrong order")
    }
    assert len(firsts["dropped blocks"]) == 9
    assert set(firsts["dropped blocks"]) < set(range(10))
    assert len(firsts["repeated block"]) == 11
    assert set(firsts["repeated block"]) == set(range(10))
    assert firsts["wrong order"] != list(range(10))
    assert sorted(firsts["wrong order"]) == list(range(10))


@pytest.mark.parametrize(("kind", "jumps"), [("gap", 1), ("hidden gap", 0)])
def test_gap_shows_in_the_times_and_hidden_gap_does_not(kind, jumps):
    blocks = stream(faulty({"kind": kind, "extent": "0.25 s"}))
    assert sum(block.samples for block in blocks) == 10_000
    assert all(a.first_sample + a.samples == b.first_sample for a, b in pairwise(blocks))
    delays = [b.monotonic_s - a.monotonic_s - a.samples / a.rate_hz for a, b in pairwise(blocks)]
    assert sum(delay == pytest.approx(0.25) for delay in delays) == jumps
    assert sum(delay == pytest.approx(0.0, abs=1e-9) for delay in delays) == len(delays) - jumps


def test_time_goes_back_once():
    times = [block.monotonic_s for block in stream(faulty({"kind": "time back"}))]
    assert sum(b < a for a, b in pairwise(times)) == 1


def test_wrong_frequency_shows_in_the_angle_and_not_in_the_read_back():
    device = faulty({"kind": "wrong frequency", "extent": "10 %"})
    blocks = stream(device, 10.0, 2.0)
    assert device.read_back("frequency") == pytest.approx(10.0)
    angle = np.concatenate([block.channels["angle"] for block in blocks])
    assert np.sum((angle[:-1] < 0) & (angle[1:] >= 0)) == pytest.approx(22, abs=1)


def test_wrong_frequency_stays_within_the_limits():
    device = faulty({"kind": "wrong frequency", "extent": "10 %"})
    device.set("frequency", 35.0)
    assert device.read_back("frequency") == pytest.approx(35.0)


def test_stuck_drive_stays_at_its_value():
    device = faulty({"kind": "stuck", "on": "set", "drive": "load"})
    device.set("load", 500.0)
    device.set("frequency", 5.0)
    assert (device.read_back("load"), device.read_back("frequency")) == (0.0, 5.0)


@pytest.mark.parametrize(
    ("kind", "error"),
    [
        ("timeout", DeviceTimeoutError),
        ("lost", DeviceLostError),
        ("rejected", DeviceRejectedError),
    ],
)
@pytest.mark.parametrize("call", ["connect", "set", "read back", "read", "stream", "make safe"])
def test_configured_call_raises_the_configured_error(kind, error, call):
    device = faulty({"kind": kind, "on": call}, connect=False)
    calls = {
        "connect": lambda: device.connect(1.0),
        "set": lambda: device.set("load", 10.0),
        "read back": lambda: device.read_back("load"),
        "read": lambda: device.read(["torque"]),
        "stream": lambda: list(device.stream(NAMES, 0.5, STOP)),
        "make safe": device.make_safe,
    }
    if call != "connect":
        device.connect(1.0)
    with pytest.raises(error, match=f"'{call}'"):
        calls[call]()
    device.close()


def test_lost_device_stays_lost_until_it_is_reconnected():
    device = faulty({"kind": "lost", "on": "set", "calls": [1]})
    with pytest.raises(DeviceLostError, match="broke in 'set'"):
        device.set("load", 1.0)
    for use in (device.make_safe, lambda: device.read(["load"]), lambda: device.read_back("load")):
        with pytest.raises(DeviceLostError, match="is lost"):
            use()
    device.connect(1.0)
    with pytest.raises(DeviceLostError, match="broke"):
        device.set("load", 1.0)


def test_late_answer_takes_its_time_and_is_not_called_inline():
    device = faulty({"kind": "late", "on": "read", "extent": "7 s"})
    start_s = device._clock.monotonic_s()
    device.read(["torque"])
    assert device._clock.monotonic_s() - start_s == 7.0
    assert not device.non_blocking
    assert faulty().non_blocking


def test_reading_is_nan():
    values = faulty({"kind": "nan", "on": "read"}).read(["torque", "load"])
    assert np.isnan(values["torque"])
    assert np.isfinite(values["load"])


def test_fault_occurs_only_at_its_set_point_and_call():
    device = faulty({"kind": "nan", "at": {"frequency": "10 Hz"}, "calls": [2]})
    for hz, expected in ((5.0, 0), (10.0, 0), (5.0, 0), (10.0, 1), (10.0, 0)):
        assert np.isnan(torque(stream(device, hz))).sum() == expected


def test_chance_depends_on_the_seed_and_not_on_the_order():
    def affected_calls(seed, order):
        device = faulty({"kind": "nan", "probability": "50 %"}, seed=seed)
        return {hz: bool(np.isnan(torque(stream(device, hz, 0.2))).any()) for hz in order}

    points = [float(hz) for hz in range(1, 31)]
    affected = affected_calls(1, points)
    assert affected == affected_calls(1, points[::-1])
    assert affected != affected_calls(2, points)
    assert 5 < sum(affected.values()) < 25  # 30 times 50 %: outside with a chance below 1 in 3000


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"kind": "spikes"}, "'spikes' needs an extent: a quantity in the channel's unit"),
        ({"kind": "gap", "extent": "1 N"}, "got '1 N', expected a time"),
        ({"kind": "lost", "extent": "1 s"}, "'lost' has no extent"),
        ({"kind": "clipped", "on": "set", "extent": "1 N·m"}, "does not affect 'set'"),
        ({"kind": "noise", "extent": "1 N"}, "got a force, torque takes a torque"),
        ({"kind": "nan", "channel": "torq"}, "no channel 'torq'"),
        ({"kind": "lost", "on": "set", "drive": "lod"}, "no drive 'lod'"),
        ({"kind": "nan", "at": {"load": "3 Hz"}}, "got a frequency, load takes a force"),
    ],
)
def test_faults_that_do_not_fit_are_refused(fault, message):
    with pytest.raises(PluginError, match=message):
        faulty(fault)


def test_wrapper_of_an_unknown_device_is_refused():
    with pytest.raises(PluginError, match="there is no device 'swing_testr'"):
        faulty(plugin="swing_testr")
