"""The base class of drivers: limits, settling, safe state, errors, exchanges."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigrunner.api.devices import (
    Approaching,
    ChannelInfo,
    Device,
    DeviceContext,
    DriveInfo,
    Identity,
    Patience,
    Readable,
)
from rigrunner.api.driver import Driver, check_patience
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig


class BackEndError(Exception):
    """The error of an instrument's library."""


class Press(Driver):
    """A press whose load moves by 100 N towards its set-point with each reading."""

    errors = {BackEndError: DeviceRejectedError}  # noqa: RUF012  (as an author would write it)

    def __init__(self, context):
        load = DriveInfo("load", "N", "Load", 0.0, 1000.0, tolerance=1.0, settle_s=2.0)
        super().__init__(context, [ChannelInfo("load", "N", "Load")], [load])
        self.load = self.set_point = 500.0
        self.step = 100.0
        self.raises = None
        self.opened = self.shuts = 0
        self.opened_within_s = None

    def open(self, timeout_s):
        self.opened += 1
        self.opened_within_s = timeout_s
        if self.raises:
            raise self.raises
        return Identity("Test", "press", "1")

    def shut(self):
        self.shuts += 1

    def get(self, channel):
        return self.exchange(f"query {channel}", self._look)

    def put(self, drive, value):
        self.exchange(f"set {drive} {value:g}", lambda: self._move(value))

    def _look(self):
        if self.raises:
            error, self.raises = self.raises, None
            raise error
        distance = self.set_point - self.load
        self.load += max(-self.step, min(self.step, distance))
        return self.load

    def _move(self, value):
        if self.raises:
            error, self.raises = self.raises, None
            raise error
        self.set_point = value


@pytest.fixture
def press():
    return Press(DeviceContext("press", SimulatedClock(), Path()))


def test_driver_with_drives_has_their_abilities(press):
    assert all(isinstance(press, ability) for ability in (Device, Readable, Approaching))


def test_set_waits_until_the_drive_arrives(press):
    press.connect(1.0)
    press.set("load", 1000.0)
    assert press.read_back("load") == 1000.0
    assert press.read(["load"]) == {"load": 1000.0}


def test_begin_does_not_wait(press):
    press.connect(1.0)
    press.begin("load", 1000.0)
    assert press.load == 500.0
    looks = 0
    while not press.arrived("load"):
        looks += 1
    assert looks == 4


def test_stuck_drive_is_reported_with_its_value(press):
    press.connect(1.0)
    press.step = 0.0
    with pytest.raises(DeviceTimeoutError, match="load reads back 500 N after 2 s, set to 0 N"):
        press.set("load", 0.0)


@pytest.mark.parametrize("wrong", [-1.0, 1001.0, float("nan"), float("inf")])
def test_limits_are_checked_before_sending(press, wrong):
    press.connect(1.0)
    with pytest.raises(DeviceRejectedError, match=r"out of range \(0 to 1000 N\)"):
        press.begin("load", wrong)
    assert press.set_point == 500.0


@pytest.mark.parametrize(
    ("raised", "expected"),
    [
        (TimeoutError(), DeviceTimeoutError),
        (ConnectionResetError("reset"), DeviceLostError),
        (BackEndError("no such command"), DeviceRejectedError),
        (DeviceNotFoundError("nobody there"), DeviceNotFoundError),
    ],
)
def test_backend_errors_become_device_errors(press, raised, expected):
    press.connect(1.0)
    press.raises = raised
    with pytest.raises(expected):
        press.read(["load"])


def test_bug_of_a_driver_is_not_mapped(press):
    press.connect(1.0)
    press.raises = ZeroDivisionError()
    with pytest.raises(ZeroDivisionError):
        press.read(["load"])


def test_only_make_safe_connects_a_closed_driver(press):
    for use in (lambda: press.read(["load"]), lambda: press.set("load", 0.0)):
        with pytest.raises(DeviceLostError, match="not connected"):
            use()
    with pytest.raises(DeviceLostError):
        press.make_safe()
    assert press.opened == 0


def test_failed_connection_is_shut(press):
    press.raises = OSError("no route")
    with pytest.raises(DeviceLostError, match="no route"):
        press.connect(1.0)
    assert press.shuts == 1


def test_make_safe_reopens_a_lost_connection(press):
    press.connect(1.0)
    press.raises = ConnectionResetError("unplugged")
    assert press.make_safe() == {"load": 0.0}
    assert press.opened == 2


def test_make_safe_reopens_a_closed_connection(press):
    press.connect(1.0)
    press.begin("load", 1000.0)
    press.close()
    assert press.make_safe() == {"load": 0.0}
    assert press.load == 0.0
    assert press.opened == 2
    assert press.read(["load"]) == {"load": 0.0}


def test_make_safe_retries_a_failed_connection(press):
    press.raises = OSError("no route")
    with pytest.raises(DeviceLostError, match="no route"):
        press.connect(1.0)
    press.raises = None
    assert press.make_safe() == {"load": 0.0}


@pytest.mark.parametrize(("given_s", "within_s"), [(1.5, 1.5), (30.0, 5.0)])
def test_reconnecting_is_limited_by_connect_time_and_half_the_answer_time(press, given_s, within_s):
    """The patience of the station for an answer is 10 s, which includes reconnecting."""
    press.connect(given_s)
    press.reconnect()
    assert press.opened_within_s == within_s


def test_make_safe_is_idempotent(press):
    press.connect(1.0)
    assert press.make_safe() == press.make_safe() == {"load": 0.0}


class Tape:
    """A wire that keeps the requests."""

    def __init__(self):
        self.requests = []

    def exchange(self, request, perform):
        self.requests.append(request)
        return perform()


def test_wire_receives_device_errors():
    class SeesErrors(Tape):
        def exchange(self, request, perform):
            try:
                return super().exchange(request, perform)
            except DeviceError as error:
                self.requests.append(type(error).__name__)
                raise

    wire = SeesErrors()
    press = Press(DeviceContext("press", SimulatedClock(), Path(), wire=wire))
    press.connect(1.0)
    press.raises = TimeoutError()
    with pytest.raises(DeviceTimeoutError):
        press.read(["load"])
    assert wire.requests == ["query load", "DeviceTimeoutError"]


class TestInARig:
    """While a drive moves, other devices are called."""

    def rig(self, press):
        return Rig({"press": press}, press.clock)

    def test_meanwhile_is_called_while_the_drive_moves(self, press):
        looks = []
        with self.rig(press) as rig:
            assert rig.set("press", "load", 1000.0, meanwhile=lambda: looks.append(press.load))
        assert looks == [600.0, 700.0, 800.0, 900.0]

    def test_meanwhile_is_called_for_a_non_blocking_device(self, press):
        looks = []
        press.non_blocking = True
        with self.rig(press) as rig:
            rig.set("press", "load", 1000.0, meanwhile=lambda: looks.append(press.load))
        assert looks == [600.0, 700.0, 800.0, 900.0]

    def test_error_of_meanwhile_ends_the_wait(self, press):
        def stop():
            raise KeyboardInterrupt

        with self.rig(press) as rig, pytest.raises(KeyboardInterrupt):
            rig.set("press", "load", 1000.0, meanwhile=stop)
        assert press.load == 0.0  # made safe

    def test_drive_that_does_not_arrive_is_named(self, press):
        press.step = 0.0
        rig = self.rig(press)
        rig.connect()
        with pytest.raises(DeviceTimeoutError, match=r"^press: load reads back 500 N after 12 s"):
            rig.set("press", "load", 1000.0)
        rig.close()


def test_answer_time_out_must_be_below_the_patience_of_the_station(tmp_path):
    context = DeviceContext("press", SimulatedClock(), tmp_path, patience=Patience(answer_s=3.0))
    check_patience(2.9, context)
    with pytest.raises(PluginError, match=r"got 3 s, expected less than 3 s.*safety.patience"):
        check_patience(3.0, context)


class TwoDrives(Driver):
    """A press and an inverter in one; `raises` has the error that `get` raises for a drive."""

    def __init__(self):
        drives = [
            DriveInfo("load", "N", "Load", 0.0, 1000.0),
            DriveInfo("speed", "Hz", "Speed", 0.0, 60.0),
        ]
        super().__init__(DeviceContext("rig", SimulatedClock(), Path()), (), drives)
        self.values = {"load": 0.0, "speed": 0.0}
        self.raises: dict[str, BaseException] = {}

    def open(self, timeout_s):  # noqa: ARG002  (the Protocol's)
        return Identity("Test", "rig", "1")

    def get(self, channel):
        if channel in self.raises:
            raise self.raises[channel]
        return self.values[channel]

    def put(self, drive, value):
        self.values[drive] = value


@pytest.mark.parametrize(
    "error", [IndexError("list index"), SystemExit(2), DeviceTimeoutError("late"), MemoryError()]
)
def test_error_of_a_drive_does_not_stop_making_the_next_safe(error):
    device = TwoDrives()
    device.connect(1.0)
    device.set("load", 500.0)
    device.set("speed", 50.0)
    device.raises["load"] = error
    with pytest.raises(type(error)):
        device.make_safe()
    assert device.values == {"load": 0.0, "speed": 0.0}


def test_first_error_of_make_safe_is_raised_with_others_as_notes():
    device = TwoDrives()
    device.connect(1.0)
    device.raises = {"load": IndexError("list index"), "speed": DeviceLostError("cable")}
    with pytest.raises(IndexError, match="list index") as caught:
        device.make_safe()
    assert caught.value.__notes__ == ["cable"]


def test_ctrl_c_during_make_safe_is_raised_after_all_drives():
    device = TwoDrives()
    device.connect(1.0)
    device.set("speed", 50.0)
    device.raises = {"load": KeyboardInterrupt()}
    with pytest.raises(KeyboardInterrupt):
        device.make_safe()
    assert device.values["speed"] == 0.0


@pytest.mark.parametrize("kind", [ChannelInfo, DriveInfo])
def test_class_record_that_is_no_tuple_is_refused(kind):
    attribute = "channels" if kind is ChannelInfo else "drives"
    bounds = () if kind is ChannelInfo else (0.0, 1000.0)

    class Careless(Driver):
        pass

    setattr(Careless, attribute, kind("load", "N", "Load", *bounds))
    with pytest.raises(PluginError, match=f"^{attribute} is one {kind.__name__}, expected a tuple"):
        Careless(DeviceContext("press", SimulatedClock(), Path()))


def test_driver_with_drives_needs_put():
    class Unfinished(Press):
        put = Driver.put

    press = Unfinished(DeviceContext("press", SimulatedClock(), Path()))
    press.connect(1.0)
    with pytest.raises(NotImplementedError):
        press.begin("load", 100.0)


def test_driver_with_readings_needs_get_reading(press):
    with pytest.raises(NotImplementedError):
        press.get_reading("serial")
