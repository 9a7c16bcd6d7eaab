"""What every driver shares: limits, settling, safe state, errors, exchanges."""

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
    """What the library of an instrument raises."""


class Press(Driver):
    """A press whose load goes to its set-point by 100 N with each look."""

    errors = {BackEndError: DeviceRejectedError}  # noqa: RUF012  (as an author would write it)

    def __init__(self, context):
        load = DriveInfo("load", "N", "Load", 0.0, 1000.0, tolerance=1.0, settle_s=2.0)
        super().__init__(context, [ChannelInfo("load", "N", "Load")], [load])
        self.stands = self.wanted = 500.0
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
        self.exchange(f"set {drive} {value:g}", lambda: self._go(value))

    def _look(self):
        if self.raises:
            error, self.raises = self.raises, None
            raise error
        distance = self.wanted - self.stands
        self.stands += max(-self.step, min(self.step, distance))
        return self.stands

    def _go(self, value):
        if self.raises:
            error, self.raises = self.raises, None
            raise error
        self.wanted = value


@pytest.fixture
def press():
    return Press(DeviceContext("press", SimulatedClock(), Path()))


def test_it_has_the_abilities_of_a_driven_instrument(press):
    assert all(isinstance(press, ability) for ability in (Device, Readable, Approaching))


def test_setting_waits_until_the_drive_is_there(press):
    press.connect(1.0)
    press.set("load", 1000.0)
    assert press.read_back("load") == 1000.0
    assert press.read(["load"]) == {"load": 1000.0}


def test_beginning_does_not_wait(press):
    press.connect(1.0)
    press.begin("load", 1000.0)
    assert press.stands == 500.0
    looks = 0
    while not press.arrived("load"):
        looks += 1
    assert looks == 4


def test_a_drive_that_does_not_move_is_told_with_where_it_stands(press):
    press.connect(1.0)
    press.step = 0.0
    with pytest.raises(DeviceTimeoutError, match="load reads back 500 N after 2 s, set to 0 N"):
        press.set("load", 0.0)


@pytest.mark.parametrize("wrong", [-1.0, 1001.0, float("nan"), float("inf")])
def test_limits_hold_before_anything_is_sent(press, wrong):
    press.connect(1.0)
    with pytest.raises(DeviceRejectedError, match=r"out of range \(0 to 1000 N\)"):
        press.begin("load", wrong)
    assert press.wanted == 500.0


@pytest.mark.parametrize(
    ("raised", "expected"),
    [
        (TimeoutError(), DeviceTimeoutError),
        (ConnectionResetError("reset"), DeviceLostError),
        (BackEndError("no such command"), DeviceRejectedError),
        (DeviceNotFoundError("nobody there"), DeviceNotFoundError),
    ],
)
def test_what_the_back_end_raises_becomes_one_of_four_errors(press, raised, expected):
    press.connect(1.0)
    press.raises = raised
    with pytest.raises(expected):
        press.read(["load"])


def test_a_bug_of_the_driver_stays_a_bug(press):
    press.connect(1.0)
    press.raises = ZeroDivisionError()
    with pytest.raises(ZeroDivisionError):
        press.read(["load"])


def test_without_a_connection_nothing_but_safety_is_tried(press):
    for use in (lambda: press.read(["load"]), lambda: press.set("load", 0.0)):
        with pytest.raises(DeviceLostError, match="not connected"):
            use()
    with pytest.raises(DeviceLostError):
        press.make_safe()
    assert press.opened == 0


def test_a_connection_that_fails_is_given_back(press):
    press.raises = OSError("no route")
    with pytest.raises(DeviceLostError, match="no route"):
        press.connect(1.0)
    assert press.shuts == 1


def test_making_safe_opens_a_lost_connection_once_more(press):
    press.connect(1.0)
    press.raises = ConnectionResetError("unplugged")
    assert press.make_safe() == {"load": 0.0}
    assert press.opened == 2


def test_making_safe_opens_a_connection_that_was_closed(press):
    press.connect(1.0)
    press.begin("load", 1000.0)
    press.close()
    assert press.make_safe() == {"load": 0.0}
    assert press.stands == 0.0
    assert press.opened == 2
    assert press.read(["load"]) == {"load": 0.0}


def test_a_connection_that_never_came_about_is_tried_once_more_to_make_safe(press):
    press.raises = OSError("no route")
    with pytest.raises(DeviceLostError, match="no route"):
        press.connect(1.0)
    press.raises = None
    assert press.make_safe() == {"load": 0.0}


@pytest.mark.parametrize(("given_s", "within_s"), [(1.5, 1.5), (30.0, 5.0)])
def test_reconnecting_may_take_as_long_as_connecting_and_half_an_answer(press, given_s, within_s):
    """The patience of the station is 10 s for an answer, of which reconnecting is a part."""
    press.connect(given_s)
    press.reconnect()
    assert press.opened_within_s == within_s


def test_making_safe_is_idempotent(press):
    press.connect(1.0)
    assert press.make_safe() == press.make_safe() == {"load": 0.0}


class Tape:
    """Keeps requests."""

    def __init__(self):
        self.requests = []

    def exchange(self, request, perform):
        self.requests.append(request)
        return perform()


def test_errors_reach_the_wire_as_device_errors():
    class Sees(Tape):
        def exchange(self, request, perform):
            try:
                return super().exchange(request, perform)
            except DeviceError as error:
                self.requests.append(type(error).__name__)
                raise

    wire = Sees()
    press = Press(DeviceContext("press", SimulatedClock(), Path(), wire=wire))
    press.connect(1.0)
    press.raises = TimeoutError()
    with pytest.raises(DeviceTimeoutError):
        press.read(["load"])
    assert wire.requests == ["query load", "DeviceTimeoutError"]


class TestInARig:
    """While the drive is on its way, others have their turn."""

    def rig(self, press):
        return Rig({"press": press}, press.clock)

    def test_others_are_called_while_it_moves(self, press):
        looks = []
        with self.rig(press) as rig:
            assert rig.set("press", "load", 1000.0, meanwhile=lambda: looks.append(press.stands))
        assert looks == [600.0, 700.0, 800.0, 900.0]

    def test_so_they_are_of_a_device_that_does_not_block(self, press):
        looks = []
        press.non_blocking = True
        with self.rig(press) as rig:
            rig.set("press", "load", 1000.0, meanwhile=lambda: looks.append(press.stands))
        assert looks == [600.0, 700.0, 800.0, 900.0]

    def test_what_they_raise_ends_the_waiting(self, press):
        def stop():
            raise KeyboardInterrupt

        with self.rig(press) as rig, pytest.raises(KeyboardInterrupt):
            rig.set("press", "load", 1000.0, meanwhile=stop)
        assert press.stands == 0.0  # made safe

    def test_one_that_does_not_arrive_is_named(self, press):
        press.step = 0.0
        rig = self.rig(press)
        rig.connect()
        with pytest.raises(DeviceTimeoutError, match=r"^press: load reads back 500 N after 12 s"):
            rig.set("press", "load", 1000.0)
        rig.close()


def test_an_answer_is_given_up_before_the_station_gives_up_the_device(tmp_path):
    context = DeviceContext("press", SimulatedClock(), tmp_path, patience=Patience(answer_s=3.0))
    check_patience(2.9, context)
    with pytest.raises(PluginError, match=r"got 3 s, expected less than 3 s.*safety.patience"):
        check_patience(3.0, context)


class TwoDrives(Driver):
    """A press and an inverter in one; what a test puts in `raises` comes of that drive's `get`."""

    def __init__(self):
        drives = [
            DriveInfo("load", "N", "Load", 0.0, 1000.0),
            DriveInfo("speed", "Hz", "Speed", 0.0, 60.0),
        ]
        super().__init__(DeviceContext("rig", SimulatedClock(), Path()), (), drives)
        self.stands = {"load": 0.0, "speed": 0.0}
        self.raises: dict[str, BaseException] = {}

    def open(self, timeout_s):  # noqa: ARG002  (the Protocol's)
        return Identity("Test", "rig", "1")

    def get(self, channel):
        if channel in self.raises:
            raise self.raises[channel]
        return self.stands[channel]

    def put(self, drive, value):
        self.stands[drive] = value


@pytest.mark.parametrize(
    "error", [IndexError("list index"), SystemExit(2), DeviceTimeoutError("late"), MemoryError()]
)
def test_no_error_of_one_drive_keeps_the_next_from_being_made_safe(error):
    device = TwoDrives()
    device.connect(1.0)
    device.set("load", 500.0)
    device.set("speed", 50.0)
    device.raises["load"] = error
    with pytest.raises(type(error)):
        device.make_safe()
    assert device.stands == {"load": 0.0, "speed": 0.0}


def test_the_first_error_of_making_safe_is_raised_with_the_others_beside_it():
    device = TwoDrives()
    device.connect(1.0)
    device.raises = {"load": IndexError("list index"), "speed": DeviceLostError("cable")}
    with pytest.raises(IndexError, match="list index") as raised:
        device.make_safe()
    assert raised.value.__notes__ == ["cable"]


def test_ctrl_c_while_one_drive_is_made_safe_is_raised_once_all_had_their_turn():
    device = TwoDrives()
    device.connect(1.0)
    device.set("speed", 50.0)
    device.raises = {"load": KeyboardInterrupt()}
    with pytest.raises(KeyboardInterrupt):
        device.make_safe()
    assert device.stands["speed"] == 0.0


@pytest.mark.parametrize("kind", [ChannelInfo, DriveInfo])
def test_records_of_the_class_that_lack_a_comma_are_refused(kind):
    what = "channels" if kind is ChannelInfo else "drives"
    bounds = () if kind is ChannelInfo else (0.0, 1000.0)

    class Careless(Driver):
        pass

    setattr(Careless, what, kind("load", "N", "Load", *bounds))
    with pytest.raises(PluginError, match=f"^{what} is one {kind.__name__}, expected a tuple"):
        Careless(DeviceContext("press", SimulatedClock(), Path()))


def test_a_driver_of_drives_without_put_is_told_so():
    class Unfinished(Press):
        put = Driver.put

    press = Unfinished(DeviceContext("press", SimulatedClock(), Path()))
    press.connect(1.0)
    with pytest.raises(NotImplementedError):
        press.begin("load", 100.0)
