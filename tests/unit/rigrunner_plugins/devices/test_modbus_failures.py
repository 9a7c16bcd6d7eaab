"""Failures of a Modbus instrument: a clear message, and a rig that is safe or reported unsafe."""

from __future__ import annotations

import math
import threading
import time
from pathlib import Path

import pytest

from helpers_devices import Listener, plan_of, run
from helpers_waiting import wait_until
from rigrunner.api import DeviceContext
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.api.events import MadeSafe, Outcome, StepStarted
from rigrunner.clock import SimulatedClock, WallClock
from rigrunner.registry import load_registry
from rigrunner.rig import Patience, Rig
from rigrunner.steps.set_drives import SetDrive
from rigrunner_plugins.devices.modbus.device import Heartbeat
from rigrunner_plugins.devices.modbus.line import Line
from rigrunner_plugins.devices.modbus.served.inverter import (
    HEARTBEAT,
    TIMEOUT,
    WATCHDOG,
    Inverter,
)
from rigrunner_plugins.devices.modbus.served.server import ModbusServer
from rigrunner_plugins.devices.modbus.settings import ModbusSettings
from rigrunner_plugins.devices.plant import Plant
from unit.rigrunner_plugins.devices.helpers_modbus import (
    FREQUENCY,
    HANG_UP,
    SILENCE,
    After,
    Cable,
    device,
    mbap,
    rtu,
    rtu_peer,
    tcp_peer,
)

CHANNELS = {"torque": {"input": 0, "unit": "N·m"}}
MAIN = (SetDrive("tester", "frequency", 10.0, "Hz"), SetDrive("tester", "frequency", 20.0, "Hz"))


@pytest.fixture
def plant():
    return Plant(frequency_rate_hz_per_s=200.0)


@pytest.fixture
def clock_of_inverter():
    return SimulatedClock()


@pytest.fixture
def real_inverter(plant, clock_of_inverter):
    return Inverter(plant, now_s=clock_of_inverter.monotonic_s)


@pytest.fixture
def server(real_inverter):
    with ModbusServer([real_inverter]) as serving:
        yield serving


@pytest.fixture
def cable(server):
    cable_ = Cable(server.port)
    yield cable_
    cable_.close()


def inverter(port, **more):
    tcp = {"host": "127.0.0.1", "port": port}
    drives = {"frequency": FREQUENCY}
    return device({"tcp": tcp, "timeout": "1 s", "retries": 0, "drives": drives, **more})


def run_with(motor, break_it):
    """Run two set-points and break something as the second begins; return summary and reports."""

    def at(event):
        if isinstance(event, StepStarted) and event.index == 1:
            break_it()

    listener = Listener(before=at)
    summary = run(motor, plan_of((), MAIN, ()), critical=[listener], clock=WallClock())
    motor.close()
    return summary, listener.of(MadeSafe)


def test_dropped_connection_is_reopened_to_stop_the_motor(plant, cable):
    summary, _ = run_with(inverter(cable.port), cable.drop)
    assert summary.outcome is Outcome.ERROR
    assert isinstance(summary.error, DeviceLostError)
    assert "tester: write 2000 to holding 1: unit 1 at 127.0.0.1" in str(summary.error)
    assert "closed the connection or was unplugged" in str(summary.error)
    assert summary.safe
    assert plant.frequency_hz == 0.0


@pytest.mark.in_real_time
def test_pulled_cable_leaves_the_motor_to_its_watchdog_and_the_run_unsafe(
    plant, cable, real_inverter, clock_of_inverter
):
    real_inverter.written(WATCHDOG, [10])  # it stops after 1 s without a request
    watchdog = {"holding": HEARTBEAT, "every": "50 ms", "write": [1]}
    summary, reports = run_with(inverter(cable.port, watchdog=watchdog), cable.swallow)
    assert summary.outcome is Outcome.ERROR
    assert "no answer from unit 1" in str(summary.error)
    assert not summary.safe
    assert "make safe failed" in reports[-1].problems[0]
    assert plant.frequency_hz == 10.0
    clock_of_inverter.sleep(1.1)
    wait_until(lambda: real_inverter.inputs()[3] == TIMEOUT)
    wait_until(lambda: plant.frequency_hz == 0.0)


class Reset:
    """A client whose connection is reset by the other end during a write."""

    def write_register(self, *_, **__):
        raise ConnectionResetError(104, "Connection reset by peer")

    def close(self):
        pass


def test_watchdog_with_a_reset_connection_is_reported_with_its_reason():
    watchdog = {"holding": HEARTBEAT, "every": "50 ms", "write": [1]}
    connection = {"tcp": {"host": "127.0.0.1", "port": 502}, "drives": {"frequency": FREQUENCY}}
    settings = ModbusSettings(**connection, timeout="400 ms", watchdog=watchdog)
    line = Line(settings)
    line._client = Reset()
    beating = Heartbeat(settings.watchdog, line)
    beating.start()
    beating._thread.join(10)
    with pytest.raises(DeviceLostError, match=r"the watchdog failed: write 1 .*closed the connect"):
        line.write(settings.watchdog, [1], multiple=False)


def test_stopped_server_leaves_a_rig_reported_unsafe(server):
    summary, reports = run_with(inverter(server.port), server.stop)
    assert isinstance(summary.error, DeviceLostError)
    assert not summary.safe
    assert "cannot be reached: Connection refused" in reports[-1].problems[0]


def test_refused_set_point_ends_the_run_with_a_stopped_motor(plant, server):
    wrong = {**FREQUENCY, "run": [{"holding": 0, "value": 1}, {"holding": 77, "value": 1}]}
    summary, _ = run_with(inverter(server.port, drives={"frequency": wrong}), lambda: None)
    assert isinstance(summary.error, DeviceRejectedError)
    assert "write 1 to holding 77" in str(summary.error)
    assert "illegal data address" in str(summary.error)
    assert "holding 77 is number 78 of manuals that count from 1, or 40078" in str(summary.error)
    assert summary.safe
    assert plant.frequency_hz == 0.0


def test_unreachable_instrument_is_reported():
    listener = Cable(1)
    port = listener.port
    listener.close()
    with pytest.raises(DeviceNotFoundError, match=rf"127.0.0.1:{port} cannot be reached"):
        inverter(port).connect(1.0)
    with pytest.raises(DeviceNotFoundError, match=r"no-such-host.invalid:502 cannot be reached"):
        device({"tcp": {"host": "no-such-host.invalid"}, "channels": CHANNELS}).connect(1.0)
    with pytest.raises(DeviceNotFoundError, match="serial port /dev/ttyNONE cannot be opened"):
        device({"rtu": {"port": "/dev/ttyNONE"}, "channels": CHANNELS}).connect(1.0)


def test_unexpected_instrument_never_moves(plant, server):
    expected = {"standard": "yes", "expect": {"model": "FC-51"}}
    rig = Rig({"motor": inverter(server.port, identification=expected)}, WallClock(), Patience())
    with pytest.raises(DeviceNotFoundError, match=r"motor: unit 1 .* has the model 'SIM-VFD'"):
        rig.connect()
    assert plant.frequency_hz == 0.0


PROBE = "04 00 00 00 01"


def connect_and_read(peer, retries=0):
    with peer as (_, connection):
        settings = {**connection, "timeout": "1 s", "retries": retries, "channels": CHANNELS}
        unit = device(settings)
        try:
            unit.connect(1.0)
            return unit.read(["torque"])
        finally:
            unit.close()


FINE = "04 02 00 07"


@pytest.mark.parametrize(
    ("answer", "error", "message"),
    [
        (SILENCE, DeviceTimeoutError, r"read input 0: no answer from unit 1 at .* within 1 s"),
        (HANG_UP, DeviceLostError, "closed the connection or was unplugged"),
        (b"HTTP/1.1 400 Bad Request\r\n", DeviceTimeoutError, r"no readable answer .* only: 48 54"),
        (mbap(2, 1, "84 06"), DeviceRejectedError, r"device busy \(exception 6\)"),
        (mbap(2, 1, "84 0B"), DeviceRejectedError, "gateway's target does not answer"),
        (mbap(2, 1, "84 63"), DeviceRejectedError, r"not in the standard \(exception 99\)"),
        (mbap(2, 1, "03 02 00 07"), DeviceRejectedError, "an answer to function 3"),
        (mbap(2, 1, "04 04 00 07 00 08"), DeviceRejectedError, "a wrong answer: 2 registers"),
        (mbap(2, 9, FINE), DeviceTimeoutError, "no readable answer"),  # another unit's
        (mbap(1, 1, FINE), DeviceTimeoutError, "no readable answer"),  # of the request before
        (mbap(2, 1, FINE)[:-1], DeviceTimeoutError, "no readable answer"),
    ],
    ids=[
        "silence", "hung up", "another protocol", "busy", "gateway", "unknown exception",
        "another function", "too many", "another unit", "a late one", "cut short",
    ],
)  # fmt: skip
def test_invalid_tcp_answer_is_reported(answer, error, message):
    script = [(mbap(1, 1, PROBE), mbap(1, 1, FINE)), (mbap(2, 1, PROBE), answer)]
    with pytest.raises(error, match=message):
        connect_and_read(tcp_peer(script))


@pytest.mark.parametrize(
    ("answer", "error", "message"),
    [
        (SILENCE, DeviceTimeoutError, "baud, parity and stop_bits correct"),
        (HANG_UP, DeviceLostError, "closed the connection or was unplugged"),
        (rtu(1, FINE)[:-1] + b"\0", DeviceTimeoutError, r"no readable answer .* only: 01 04 02"),
        (rtu(9, FINE), DeviceTimeoutError, "no readable answer"),
    ],
    ids=["silence", "unplugged", "wrong checksum", "another unit"],
)
def test_invalid_serial_answer_is_reported(answer, error, message):
    script = [(rtu(1, PROBE), rtu(1, FINE)), (rtu(1, PROBE), answer)]
    with pytest.raises(error, match=message):
        connect_and_read(rtu_peer(script))


def test_lost_request_is_repeated():
    script = [
        (rtu(1, PROBE), rtu(1, FINE)),
        (rtu(1, PROBE), SILENCE),
        (rtu(1, PROBE), rtu(1, "04 02 00 09")),
    ]
    assert connect_and_read(rtu_peer(script), retries=1) == {"torque": 9.0}


@pytest.mark.parametrize(
    ("echo", "message"),
    [
        ("06 00 01 03 E9", r"write 1000 to holding 1: .* echo of \[1001"),
        ("06 00 02 03 E8", "write 1000 to holding 1: .* echo of address 2"),
    ],
)
def test_different_echo_is_no_confirmation(echo, message):
    probe = "03 00 01 00 01"
    script = [
        (mbap(1, 1, probe), mbap(1, 1, "03 02 00 00")),
        (mbap(2, 1, "06 00 01 03 E8"), mbap(2, 1, echo)),
    ]
    drive = {key: FREQUENCY[key] for key in ("holding", "scale", "unit", "min", "max", "safe")}
    with tcp_peer(script) as (_, connection):
        unit = device({**connection, "timeout": "2 s", "drives": {"frequency": drive}})
        unit.connect(1.0)
        with pytest.raises(DeviceRejectedError, match=message):
            unit.begin("frequency", 10.0)
        unit.close()


def test_busy_unit_is_asked_again():
    script = [
        (mbap(1, 1, PROBE), mbap(1, 1, FINE)),
        (mbap(2, 1, PROBE), mbap(2, 1, "84 06")),
        (mbap(3, 1, PROBE), mbap(3, 1, "04 02 00 09")),
    ]
    assert connect_and_read(tcp_peer(script), retries=1) == {"torque": 9.0}


def test_late_serial_answer_is_not_taken_for_that_of_the_next_request():
    other = "04 00 05 00 01"
    fine, late, gave_up = rtu(1, FINE), rtu(1, "04 02 00 63"), threading.Event()
    script = [
        (rtu(1, PROBE), fine),
        (rtu(1, PROBE), After(gave_up, late)),
        (rtu(1, other), rtu(1, "04 02 00 09")),
    ]
    channels = {**CHANNELS, "angle": {"input": 5, "unit": "deg"}}
    with rtu_peer(script) as (_, connection):
        unit = device({**connection, "timeout": "1 s", "retries": 0, "channels": channels})
        unit.connect(1.0)
        with pytest.raises(DeviceTimeoutError):
            unit.read(["torque"])
        gave_up.set()
        assert unit.read(["angle"]) == {"angle": pytest.approx(math.radians(9))}
        unit.close()


def test_no_request_takes_longer_than_the_station_waits():
    script = [(rtu(1, PROBE), rtu(1, FINE)), *4 * [(rtu(1, PROBE), SILENCE)]]
    with rtu_peer(script) as (_, connection):
        settings = {**connection, "timeout": "500 ms", "retries": 1, "channels": CHANNELS}
        unit = device(settings)
        unit.connect(1.0)
        with pytest.raises(DeviceTimeoutError):
            unit.read(["torque"])
        start_s = time.monotonic()
        with pytest.raises(DeviceTimeoutError):
            unit.read(["torque"])
        took_s = time.monotonic() - start_s
        unit.close()
        context = DeviceContext("motor", WallClock(), Path(), patience=Patience(answer_s=1.75))
        assert took_s > context.patience.answer_s
        with pytest.raises(PluginError, match=r"got 2 s, expected less than 1[.]75 s"):
            load_registry().make_device("modbus", settings, context)


@pytest.mark.parametrize("bit", [24, 31, 32, 39])
def test_serial_answer_with_a_flipped_bit_is_not_accepted(bit):
    answer = bytearray(rtu(1, FINE))
    answer[bit // 8] ^= 1 << bit % 8
    with pytest.raises(DeviceTimeoutError, match="no readable answer"):
        connect_and_read(rtu_peer([(rtu(1, PROBE), rtu(1, FINE)), (rtu(1, PROBE), bytes(answer))]))
