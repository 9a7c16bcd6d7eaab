"""Simulated Modbus instruments, and the plant that they act on."""

from __future__ import annotations

import pytest

from rigrunner_plugins.devices.modbus.served.inverter import (
    AT_SET_POINT,
    FAULT,
    READY,
    RUNNING,
    TIMEOUT,
    Inverter,
)
from rigrunner_plugins.devices.modbus.served.press import Press
from rigrunner_plugins.devices.plant import Plant


class ManualClock:
    """A clock that is moved by hand."""

    now_s = 100.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def clock():
    return ManualClock()


@pytest.fixture
def plant(clock):
    return Plant(frequency_rate_hz_per_s=20.0, load_rate_n_per_s=1000.0, now_s=clock)


def test_plant_moves_at_its_rate_and_can_reverse(plant, clock):
    plant.go_to_frequency(30.0)
    clock.now_s += 1.0
    assert plant.frequency_hz == 20.0
    plant.go_to_frequency(10.0)
    clock.now_s += 0.25
    assert plant.frequency_hz == 15.0
    clock.now_s += 10.0
    assert plant.frequency_hz == 10.0


def test_inverter_runs_the_motor_only_while_its_control_word_is_set(plant, clock):
    inverter = Inverter(plant, now_s=clock)
    inverter.written(1, [1000])
    clock.now_s += 1.0
    assert plant.frequency_hz == 0.0
    inverter.written(0, [1])
    clock.now_s += 0.25
    assert list(inverter.inputs()) == [READY | RUNNING, 500, 65, 0]  # 0.4 A + 5 Hz * 0.05 A/Hz
    clock.now_s += 0.25
    assert inverter.inputs()[0] == READY | RUNNING | AT_SET_POINT
    inverter.written(0, [0])
    clock.now_s += 0.5
    assert list(inverter.inputs()) == [READY, 0, 0, 0]


def test_inverter_without_heartbeat_stops_the_motor_until_reset(plant, clock):
    inverter = Inverter(plant, now_s=clock)
    inverter.written(0, [1, 2000, 0, 5])  # watchdog of 0.5 s
    clock.now_s += 0.4
    inverter.tick()
    inverter.written(2, [1])
    clock.now_s += 0.4
    inverter.tick()
    assert plant.frequency_hz == pytest.approx(16.0)
    clock.now_s += 0.2
    inverter.tick()
    clock.now_s += 2.0
    assert plant.frequency_hz == 0.0
    assert inverter.inputs()[0] == FAULT
    assert inverter.inputs()[3] == TIMEOUT
    inverter.written(0, [1])
    clock.now_s += 1.0
    assert plant.frequency_hz == 0.0
    inverter.written(0, [0x80])
    inverter.written(0, [1])
    clock.now_s += 0.1
    assert plant.frequency_hz == pytest.approx(2.0)


def test_value_out_of_range_is_refused(plant):
    inverter, press = Inverter(plant), Press(plant)
    assert inverter.written(1, [5001]) is not None
    assert press.written(1, [0x8000, 0x453B]) is None  # IEEE 754: 453B8000 hex is 3000
    assert press.written(1, [0x9000, 0x453B]) is not None  # 3001
    assert press.written(1, [0x0000, 0xC47A]) is not None  # -1000


def test_press_takes_its_load_as_a_float_with_the_low_word_first(plant, clock):
    press = Press(plant)
    # IEEE 754: 447A0000 hex is 1000
    assert press.written(0, [1, 0x0000, 0x447A]) is None
    clock.now_s += 0.5
    assert plant.load_n == 500.0
    assert list(press.inputs()) == [0x0000, 0x43FA, 1]  # 43FA0000 hex is 500
    press.written(0, [0])
    clock.now_s += 0.5
    assert plant.load_n == 0.0
