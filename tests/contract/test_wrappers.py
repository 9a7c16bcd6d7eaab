"""A wrapper of a device passes on all its abilities: a missing one makes results wrong.

A recording without the alignment of its clocks, for example, would pass for one of a single clock.
"""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from rigrunner.api import devices
from rigrunner.api.devices import Approaching, DeviceContext, DirectWire, KnowsStream
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.tape import device as tape
from rigrunner_plugins.devices.fault import device as fault

NO_ABILITY = {"Clock", "StopToken", "MakeDevice", "Wire", "Device", "DeviceLog"}
ABILITIES = {
    kind
    for name, kind in vars(devices).items()
    if getattr(kind, "_is_protocol", False)
    and kind.__module__ == devices.__name__
    and name not in NO_ABILITY
}
TWO_CLOCKS = {
    "parts": {
        "one": {"plugin": "swing_tester_sim", "settings": {"seed": 1}},
        "two": {"plugin": "swing_tester_sim", "settings": {"seed": 2}},
    },
    "channels": {"torque": "one.torque", "angle": "two.angle"},
    "drives": {"frequency": "one.frequency"},
}


def test_tape_passes_on_every_ability():
    assert set(tape._PARTS) == ABILITIES


def test_fault_passes_on_every_ability_but_approaching():
    assert set(fault._PARTS) | {Approaching} == ABILITIES


@pytest.mark.parametrize("wrap", ["tape", "fault"])
def test_clock_alignment_is_passed_on(wrap):
    context = DeviceContext("tester", SimulatedClock(), Path())
    if wrap == "tape":
        inner = load_registry().make_device("composite", TWO_CLOCKS, context)
        device = tape.taped(inner, DirectWire())
    else:
        wrapped = {"plugin": "composite", "settings": TWO_CLOCKS}
        device = load_registry().make_device("fault", wrapped, context)
    assert isinstance(device, KnowsStream)
    device.connect(1.0)
    assert (
        sum(b.samples for b in device.stream(["angle", "torque"], 0.3, threading.Event())) == 3000
    )
    value, unit = device.stream_conditions()["angle_alignment_u"]
    assert value == pytest.approx(0.01 / 6**0.5, rel=1e-3)
    assert unit == "s"
