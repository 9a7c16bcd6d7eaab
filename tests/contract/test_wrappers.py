"""What wraps a device hands on every ability of it: one that is dropped is a result gone wrong.

A recording whose alignment is not handed on, for one, would pass for one of a single clock.
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


def test_a_tape_hands_on_every_ability():
    assert set(tape._PARTS) == ABILITIES


def test_a_fault_hands_on_every_ability_but_to_be_waited_for():
    assert set(fault._PARTS) | {Approaching} == ABILITIES


@pytest.mark.parametrize("wrap", ["tape", "fault"])
def test_how_clocks_were_aligned_is_handed_on(wrap):
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
