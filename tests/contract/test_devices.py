"""Properties of every shipped tester beyond the conformance kit, made through the registry.

Devices for real instruments are tested against peers that speak their protocol, elsewhere.
"""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

from rigrunner.api.devices import Device, DeviceContext, Readable, Settable, Streaming
from rigrunner.api.errors import DeviceRejectedError
from rigrunner.api.unit_tables import UNITS
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry

REGISTRY = load_registry()
ALL = REGISTRY.names("device")
WRAPPERS = ["composite", "fault"]
DEVICES = [
    each for each in ALL if each in WRAPPERS or REGISTRY.find("device", each).record.simulated
]
TESTERS = [*WRAPPERS, "replay", "swing_tester_ode", "swing_tester_sim"]
SI_SYMBOLS = {unit.symbol for unit in UNITS if (unit.factor, unit.offset) == (1, 0)}


class Stop:
    """A stop token that is set after a number of checks."""

    def __init__(self, after=10**9):
        self.looks = after

    def is_set(self):
        self.looks -= 1
        return self.looks < 0


def _settings(name, folder):
    if name == "tabulated":
        value = {"frequency": "10 Hz", "angle": "2 deg", "torque": "1.2 N·m"}
        points = ["frequency", "load"]
        rows = [{**value, "load": load} for load in ("0 N", "100 N")]
        return {"title": "T", "set_points": points, "cycle_frequency": "frequency", "rows": rows}
    if name == "fault":
        return {"plugin": "swing_tester_sim", "settings": {"seed": 3}}
    if name == "composite":
        names = ["angle", "torque", "load", "temperature", "humidity"]
        return {
            "parts": {"rig": {"plugin": "swing_tester_sim", "settings": {"seed": 3}}},
            "channels": {name: f"rig.{name}" for name in names},
            "drives": {"frequency": "rig.frequency", "load": "rig.load"},
        }
    if name != "replay":
        return {"seed": 3}
    angle = np.sin(np.arange(6000) / 50)
    np.savetxt(folder / "10.csv", np.c_[angle, 2 * angle], delimiter=",", header="a,t", comments="")
    folder.joinpath("manifest.yaml").write_text(
        "rigrunner: replay/1\n"
        "recordings:\n"
        "  - {frequency: 0 Hz, load: 0 N, values: {angle: 0 deg, torque: 0.01 N·m}}\n"
        "  - {frequency: 10 Hz, load: 0 N, file: 10.csv}\n"
    )
    columns = {"angle": {"column": "a", "unit": "deg"}, "torque": {"column": "t", "unit": "N·m"}}
    return {"folder": str(folder), "rate": "10 kHz", "channels": columns}


@pytest.fixture(params=DEVICES)
def name(request):
    return request.param


@pytest.fixture
def clock():
    return SimulatedClock()


only_testers = pytest.mark.parametrize("name", TESTERS, indirect=True)
"""Streams, and the two drives of a tester, apply to no other device."""


@pytest.fixture
def device(name, clock, tmp_path):
    context = DeviceContext("tester", clock, tmp_path)
    return REGISTRY.make_device(name, _settings(name, tmp_path), context)


@pytest.fixture
def connected(device):
    device.connect(1.0)
    yield device
    device.close()


def test_shipped_devices_are_registered():
    assert set(DEVICES) >= {*TESTERS, "rotation_tester_sim", "tabulated"}


@only_testers
def test_tester_has_all_abilities(device):
    for ability in (Device, Readable, Settable, Streaming):
        assert isinstance(device, ability)


def test_channels_and_drives_are_in_si_units_before_connecting(device):
    assert {"angle", "torque"} <= {info.name for info in device.channels}
    assert device.drives[0].name == "frequency"
    assert {info.unit for info in (*device.channels, *device.drives)} <= SI_SYMBOLS
    assert [info.sets_cycle_frequency for info in device.drives] == [True, False]


def test_drive_follows_its_set_point_within_its_limits(connected):
    for info in connected.drives:
        connected.set(info.name, info.maximum)
        assert connected.read_back(info.name) == info.maximum
        for wrong in (info.minimum - 1, info.maximum * 1.01, float("nan"), float("inf")):
            with pytest.raises(DeviceRejectedError, match="out of range") as caught:
                connected.set(info.name, wrong)
            assert f"{info.maximum:g} {info.unit}" in str(caught.value)
        assert connected.read_back(info.name) == info.maximum


def test_drive_moves_at_its_rate(connected, clock):
    for info in connected.drives:
        before = clock.monotonic_s()
        connected.set(info.name, info.maximum)
        duration_s = info.maximum / info.rate_per_s if info.rate_per_s else 0.0
        assert clock.monotonic_s() - before == pytest.approx(duration_s)


def test_make_safe_works_repeatedly_in_any_state(device, connected):
    safe = {info.name: info.safe_value for info in device.drives}
    for info in device.drives:
        connected.set(info.name, info.maximum)
    assert connected.make_safe() == safe
    assert connected.make_safe() == safe
    assert {name: connected.read_back(name) for name in safe} == safe
    connected.set("frequency", device.drives[0].maximum)
    device.close()
    device.close()
    assert device.make_safe() == safe


@only_testers
def test_stream_is_gapless_in_blocks_of_a_tenth_of_a_second(connected, clock):
    connected.set("frequency", 10.0)
    before = clock.monotonic_s()
    blocks = list(connected.stream(["angle", "torque"], 0.55, Stop()))
    rate = connected.sample_rate_hz
    assert sum(block.samples for block in blocks) == round(0.55 * rate)
    assert all(a.first_sample + a.samples == b.first_sample for a, b in pairwise(blocks))
    assert max(block.samples for block in blocks) <= 0.1 * rate
    assert {tuple(block.channels) for block in blocks} == {("angle", "torque")}
    assert blocks[-1].monotonic_s == pytest.approx(before + blocks[-1].first_sample / rate)
    assert clock.monotonic_s() - before == pytest.approx(0.55)


@only_testers
def test_streamed_angle_is_finite_and_swings(connected):
    connected.set("frequency", 10.0)
    blocks = list(connected.stream(["angle"], 0.5, Stop()))
    angle = np.concatenate([block.channels["angle"] for block in blocks])
    assert np.isfinite(angle).all()
    assert angle.min() < -0.01 < 0.01 < angle.max()


@pytest.mark.parametrize("package", ["rigrunner_bearings", "rigrunner_plugins"])
def test_declaring_devices_loads_no_numpy(package):
    code = f"import sys, {package}.hooks as h; h.rigrunner_devices()"
    code += "; print('numpy' in sys.modules or 'scipy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
