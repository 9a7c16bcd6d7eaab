"""Modbus instruments against pymodbus' own server, over TCP and over a serial line."""

from __future__ import annotations

import sys
import threading
from contextlib import contextmanager

import pytest

from helpers_waiting import wait_until
from rigrunner.api.errors import DeviceNotFoundError, DeviceRejectedError, MissingPackageError
from rigrunner.clock import SimulatedClock
from rigrunner_plugins.devices.modbus.grouping import Span
from rigrunner_plugins.devices.modbus.places import Place
from rigrunner_plugins.devices.modbus.served.inverter import (
    HEARTBEAT,
    OVERLOAD,
    TIMEOUT,
    WATCHDOG,
    Inverter,
)
from rigrunner_plugins.devices.modbus.served.press import Press
from rigrunner_plugins.devices.modbus.served.server import ModbusServer
from rigrunner_plugins.devices.plant import Plant
from unit.rigrunner_plugins.devices.helpers_modbus import FREQUENCY, device, modbus_line

FLOAT = {"type": "float32", "word_order": "little", "unit": "N"}
LOAD = {
    **FLOAT,
    "holding": 1,
    "min": "0 N",
    "max": "3 kN",
    "safe": "0 N",
    "rate": "20 kN/s",
    "settle": "1 s",
    "read_back": {"input": 0, **FLOAT},
    "run": [{"holding": 0, "value": 1}],
    "stop": [{"holding": 0, "value": 0}],
}
CHANNELS = {
    "frequency": {"input": 1, "scale": 0.01, "unit": "Hz"},
    "current": {"input": 2, "scale": 0.01, "unit": "A"},
    "running": {"input": 0, "bit": 1, "unit": "1"},
}


class CountsBeats(Inverter):
    beats = 0

    def written(self, address, words):
        problem = super().written(address, words)
        self.beats += address == HEARTBEAT
        return problem


@pytest.fixture
def plant():
    return Plant(frequency_rate_hz_per_s=200.0, load_rate_n_per_s=20_000.0)


@pytest.fixture
def clock_of_inverter():
    return SimulatedClock()


@pytest.fixture
def inverter(plant, clock_of_inverter):
    return CountsBeats(plant, now_s=clock_of_inverter.monotonic_s)


@pytest.fixture
def server(plant, inverter):
    with ModbusServer([inverter, Press(plant)]) as serving:
        yield serving


def settings(server, **more):
    tcp = {"host": "127.0.0.1", "port": server.port}
    settings = {"channels": CHANNELS, "drives": {"frequency": FREQUENCY}}
    return {"tcp": tcp, "timeout": "1500 ms", **settings, **more}


@contextmanager
def connected(server, **more):
    unit = device(settings(server, **more))
    unit.connect(2.0)
    try:
        yield unit
    finally:
        unit.close()


def test_inverter_is_driven_read_and_stopped(server, plant):
    with connected(server) as motor:
        motor.set("frequency", 10.0)
        assert plant.frequency_hz == pytest.approx(10.0)
        assert motor.read(["running", "current", "frequency"]) == {
            "running": 1.0,
            "current": pytest.approx(0.9),  # 0.4 A + 10 Hz * 0.05 A/Hz
            "frequency": pytest.approx(10.0),
        }
        assert motor.make_safe() == {"frequency": 0.0}
        assert motor.read(["running"]) == {"running": 0.0}
    assert plant.frequency_hz == 0.0


def test_drive_is_stopped_at_its_safe_value_even_if_not_zero(server, monkeypatch):
    idle = {**FREQUENCY, "safe": "5 Hz"}
    unit, written = device(settings(server, drives={"frequency": idle})), []
    monkeypatch.setattr(
        unit, "_write", lambda place, words, **_: written.append((place.address, words[0]))
    )
    unit.put("frequency", 5.0)
    assert written == [(0, 0), (1, 500)]  # the stop comes first
    written.clear()
    unit.put("frequency", 0.0)
    assert written == [(1, 0), (0, 1)]


def test_press_is_another_unit_of_the_same_server(server, plant):
    unit2 = {"channels": {"load": {"input": 0, **FLOAT}}, "drives": {"load": LOAD}, "unit_id": 2}
    with connected(server, **unit2) as press:
        press.set("load", 1000.0)
        assert press.read(["load"])["load"] == pytest.approx(1000.0, abs=30.0)
        assert plant.load_n == pytest.approx(1000.0)
        assert press.make_safe() == {"load": pytest.approx(0.0, abs=30.0)}


def test_identity_is_read_and_another_model_is_refused(server):
    threads = threading.active_count()
    standard = {"standard": "yes", "expect": {"maker": "Rigrunner", "model": "SIM-VFD"}}
    unit = device(settings(server, identification=standard))
    identity = unit.connect(2.0)
    unit.close()
    assert (identity.maker, identity.model, identity.firmware) == ("Rigrunner", "SIM-VFD", "1.0")
    other = device(settings(server, identification={**standard, "expect": {"model": "FC-51"}}))
    with pytest.raises(DeviceNotFoundError, match="the model 'SIM-VFD', expected 'FC-51'"):
        other.connect(2.0)
    assert threading.active_count() == threads


def test_identity_can_be_read_from_registers(server):
    parts = {"serial": {"input": 3}, "model": {"input": 3, "text": 1}}
    unit = device(settings(server, identification=parts))
    identity = unit.connect(2.0)
    assert (identity.maker, identity.serial) == ("unknown", "0")
    unit.close()


def test_fault_of_the_inverter_is_reported_with_its_name(server, inverter):
    fault = {"input": 3, "codes": {"7": "overload"}}
    with connected(server, fault=fault) as motor:
        motor.set("frequency", 5.0)
        inverter.trip(OVERLOAD)
        with pytest.raises(DeviceRejectedError, match=r"unit 1 at .* is in fault 7: overload"):
            motor.set("frequency", 10.0)
        assert motor.make_safe() == {"frequency": 0.0}


def test_set_point_that_the_unit_refuses_is_reported(server):
    drive = {**FREQUENCY, "max": "60 Hz"}
    with connected(server, drives={"frequency": drive}) as motor:
        with pytest.raises(
            DeviceRejectedError, match=r"write 6000 to holding 1.*illegal data value"
        ):
            motor.set("frequency", 60.0)
        assert motor.make_safe() == {"frequency": 0.0}


def test_watchdog_keeps_the_inverter_running(server, plant, inverter, clock_of_inverter):
    watchdog = {"holding": HEARTBEAT, "every": "10 ms", "write": [0, 1]}
    inverter.written(WATCHDOG, [10])  # it stops after 1 s without a request
    with connected(server, watchdog=watchdog) as motor:
        motor.set("frequency", 10.0)
        for _ in range(4):
            clock_of_inverter.sleep(0.9)
            beats = inverter.beats + 2  # the first one may have come before that
            wait_until(lambda due=beats: inverter.beats >= due)
        assert plant.frequency_hz == 10.0


def test_inverter_stops_without_a_watchdog_to_serve_it(server, plant, inverter, clock_of_inverter):
    inverter.written(WATCHDOG, [10])
    with connected(server) as motor:
        motor.set("frequency", 10.0)
        clock_of_inverter.sleep(1.1)
        wait_until(lambda: inverter.inputs()[3] == TIMEOUT)
        wait_until(lambda: plant.frequency_hz == 0.0)


def test_failed_watchdog_is_reported_with_its_reason(server):
    wrong = {"holding": 40, "every": "50 ms", "write": [1]}
    with connected(server, watchdog=wrong) as motor:
        motor._heartbeat._thread.join()
        with pytest.raises(Exception, match=r"the watchdog failed: write 1 to holding 40.*address"):
            motor.read(["frequency"])


def test_threads_and_sockets_are_released(server):
    watchdog = {"holding": 2, "every": "50 ms", "write": [0]}
    threads = threading.active_count()
    for _ in range(3):
        unit = device(settings(server, watchdog=watchdog))
        unit.connect(2.0)
        unit.connect(2.0)
        unit.close()
        unit.close()
    assert threading.active_count() == threads


def test_missing_package_names_the_extra(server, monkeypatch):
    monkeypatch.setitem(sys.modules, "pymodbus", None)
    monkeypatch.setitem(sys.modules, "pymodbus.exceptions", None)
    monkeypatch.delitem(sys.modules, "rigrunner_plugins.devices.modbus.line")
    unit = device(settings(server))
    with pytest.raises(
        MissingPackageError, match=r"'pymodbus' is not installed.*rigrunner\[modbus"
    ):
        unit.connect(1.0)


def test_neighbouring_registers_are_read_in_one_request(server):
    with connected(server) as motor:
        requests = []
        line = motor._line
        motor._opened.read = lambda span: requests.append(span) or type(line).read(line, span)
        motor.read(["frequency", "current", "running"])
    assert requests == [Span("input", 0, 3)]


def test_several_units_share_a_line(server, plant):
    load = {**LOAD, "unit_id": 2, "read_back": {"input": 0, "unit_id": 2, **FLOAT}}
    commands = {key: [{**LOAD[key][0], "unit_id": 2}] for key in ("run", "stop")}
    drives = {"frequency": FREQUENCY, "load": {**load, **commands}}
    channels = {**CHANNELS, "load": {"input": 0, "unit_id": 2, **FLOAT}}
    with connected(server, channels=channels, drives=drives) as rig:
        rig.set("load", 500.0)
        rig.set("frequency", 10.0)
        assert (plant.load_n, plant.frequency_hz) == pytest.approx((500.0, 10.0))
        values = rig.read(["load", "running"])
        assert values == {"load": pytest.approx(500.0), "running": 1.0}
        with pytest.raises(DeviceRejectedError, match=r"unit 2 at .* illegal data address"):
            rig._write(Place(holding=77, unit_id=2), [1])
        rig.make_safe()
    assert (plant.load_n, plant.frequency_hz) == (0.0, 0.0)


def test_inverter_is_driven_over_a_serial_line():
    plant = Plant(frequency_rate_hz_per_s=500.0)
    with modbus_line(Inverter(plant)) as port:
        rtu = {"port": port, "baud": 115200}
        settings = {"channels": CHANNELS, "drives": {"frequency": FREQUENCY}}
        motor = device({"rtu": rtu, "timeout": "1500 ms", **settings})
        motor.connect(2.0)
        motor.set("frequency", 20.0)
        assert motor.read(["running", "frequency"]) == {
            "running": 1.0,
            "frequency": pytest.approx(20.0),
        }
        assert motor.make_safe() == {"frequency": 0.0}
        motor.close()
