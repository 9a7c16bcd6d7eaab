"""Instruments that send lines: their values, and messages about invalid lines."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager, suppress
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers_devices import FakeTester, plan_of
from helpers_waiting import wait_until
from rigrunner.api.devices import Device, Identity, Readable, Streaming
from rigrunner.api.errors import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.api.events import Outcome
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.rig import Rig
from rigrunner_plugins.devices.serial_ascii.line_buffer import LineBuffer
from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings
from unit.rigrunner_plugins.devices.helpers_instruments import REGISTRY, instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import SILENCE, Lines, SerialPeer

RATE_HZ = 200.0
CELL = {
    "serial": {"baud": 115200},
    "termination": "CRLF",
    "channels": {
        "load": {"field": 1, "separator": ";", "unit_in_answer": "kN", "unit": "kN"},
        "torque": {"field": 2, "separator": ";", "unit_in_answer": "Nm", "unit": "N·m"},
    },
    "ignore": "#.*",
    "stale": "5 s",
    "rubbish": 3,
    "rate": "200 Hz",
}


def run_on(rig):
    """Run the plan of the fake tester on a rig that has more devices."""
    return run_plan(
        plan_of(), rig, Bus(), rig.clock, UnattendedAnswers(), threading.Event(), "test-run"
    )


def line(number):
    return f"{number / 1000:+09.3f} kN; {number:+07d} Nm\r\n".encode()


class HeardClock(SimulatedClock):
    """Time that passes with each line that is heard: the listening thread asks for its time."""

    def __init__(self, rate_hz):
        super().__init__()
        self.rate_hz = rate_hz

    def monotonic_s(self):
        if threading.current_thread().name.startswith("lines of"):
            self.sleep(1 / self.rate_hz)
        return super().monotonic_s()


class Talker:
    """Sends lines until it is hushed."""

    def __init__(self, far, make=line):
        self.far, self.make, self.said = far, make, 0
        self.quiet = threading.Event()
        self.thread = threading.Thread(target=self.talk, daemon=True)
        self.thread.start()

    def talk(self):
        with suppress(OSError):
            while not self.quiet.is_set():
                self.far.say(self.make(self.said))
                self.said += 1
                time.sleep(1 / RATE_HZ)

    def hush(self):
        self.quiet.set()
        self.thread.join()


@contextmanager
def cell(make=line, rate_hz=RATE_HZ, **changes):
    """Yield a load cell whose lines are heard at a rate."""
    far = SerialPeer()
    settings = merged(CELL, port=far.port, **changes)
    device = instrument("serial_ascii", settings, HeardClock(rate_hz))
    device.talker = Talker(far, make)
    device.far = far
    try:
        yield device
    finally:
        device.close()
        device.talker.hush()
        far.close()


def fall_silent(device, for_s):
    """Let no more lines come, and that time pass since the last one was heard."""
    device.talker.hush()
    wait_until(lambda: device.read(["torque"])["torque"] == device.talker.said - 1)
    device.clock.sleep(for_s)


class Stop:
    def __init__(self, after=10**9):
        self.looks = after

    def is_set(self):
        self.looks -= 1
        return self.looks < 0


def test_device_has_its_abilities():
    settings = merged(CELL, port="/dev/ttyUSB0")
    device = instrument("serial_ascii", settings)
    assert all(isinstance(device, ability) for ability in (Device, Readable, Streaming))
    without_rate = instrument("serial_ascii", merged(settings, rate=None))
    assert not isinstance(without_rate, Streaming)
    assert device.make_safe() == {}


def test_newest_line_gives_all_channels():
    with cell() as device:
        identity = Identity("unidentified", f"instrument at {device.far.port}", "")
        assert device.connect(2.0) == identity
        first = device.read(["torque", "load"])
        assert list(first) == ["torque", "load"]
        assert first["load"] == pytest.approx(first["torque"])  # n N·m, n / 1000 kN
        wait_until(lambda: device.read(["load"])["load"] >= first["load"] + 10)


def test_line_begun_before_listening_is_ignored():
    with cell(make=lambda _: SILENCE) as device:

        def say_once_it_listens():
            wait_until(lambda: device._lines)
            device.far.say(b"7.000 kN; 000000 Nm\r\n")
            wait_until(lambda: not device._lines._buffer._begins_within_a_line)
            heard.append(device._lines._buffer._last)
            device.far.say(line(5))

        heard = []
        threading.Thread(target=say_once_it_listens).start()
        device.connect(1.0)
        assert heard == [None]
        assert device.read(["torque"]) == {"torque": 5.0}


def test_lines_that_match_ignore_are_skipped():
    with cell(make=lambda n: line(n) if n % 2 else b"# battery low\r\n") as device:
        device.connect(1.0)
        assert not any(device._lines.newest().startswith("#") for _ in range(3))


@given(st.lists(st.integers(0, 99), min_size=1, max_size=8), st.data())
def test_lines_do_not_depend_on_how_their_bytes_arrive(numbers, data):
    settings = SerialAsciiSettings.model_validate(merged(CELL, port="/dev/ttyUSB0"))
    buffer = LineBuffer(settings, SimulatedClock())
    sent = b"cut off\r\n" + b"".join(map(line, numbers))
    buffer.record()
    while sent:
        size = data.draw(st.integers(1, len(sent)))
        buffer.feed(sent[:size])
        sent = sent[size:]
    received = [settings.values_in(line.text)["torque"] for line in buffer.recorded()]
    assert received == numbers


class TestSilence:
    def test_missing_lines_time_out(self):
        message = r"nothing came within 0.3 s.*`start`"
        with (
            cell(make=lambda _: SILENCE, stale="300 ms") as device,
            pytest.raises(DeviceTimeoutError, match=message),
        ):
            device.connect(1.0)

    def test_stale_value_is_not_returned(self):
        with cell(stale="1 s") as device:
            device.connect(1.0)
            fall_silent(device, for_s=1.2)
            with pytest.raises(DeviceTimeoutError, match=r"the last one, '.*Nm', came 1\.2 s ago"):
                device.read(["load"])

    def test_reading_resumes_when_lines_return(self):
        with cell(stale="1 s") as device:
            device.connect(1.0)
            fall_silent(device, for_s=1.2)
            with pytest.raises(DeviceTimeoutError):
                device.read(["load"])
            device.talker = Talker(device.far)
            assert device.read(["load"])

    def test_wrong_termination_is_reported(self):
        message = r"characters come, .* but no ETX.*baud rate"
        with (
            cell(termination="ETX", stale="1 s") as device,
            pytest.raises(DeviceTimeoutError, match=message),
        ):
            device.connect(1.0)


class TestInvalidLines:
    def test_wrong_unit_is_refused(self):
        with cell(make=lambda n: line(n).replace(b"kN", b"lbf")) as device:
            message = r"[3-9] lines in a row could not be read; the last: for load, a line is '.*':"
            message += r" after the number is 'lbf', expected 'kN'"
            with pytest.raises(DeviceRejectedError, match=message):
                device.connect(1.0)

    def test_single_invalid_line_does_not_affect_a_reading(self):
        with cell(make=lambda n: b"\xff~~\r\n" if n % 3 == 0 else line(n)) as device:
            device.connect(1.0)
            for number in (10, 20, 30):
                wait_until(lambda due=number: device.read(["torque"])["torque"] >= due)

    def test_single_invalid_line_ends_a_recording(self):
        with cell(make=lambda n: b"~~\r\n" if n % 60 == 0 else line(n)) as device:
            device.connect(1.0)
            with pytest.raises(DeviceRejectedError, match=r"for load, a line is '~~'"):
                list(device.stream(["load"], 1.0, Stop()))


class TestUnplugged:
    def test_unplugged_cable_is_reported_while_reading(self):
        with cell() as device:
            device.connect(1.0)
            device.far.unplug()
            device._lines._thread.join()
            with pytest.raises(DeviceLostError, match=r"is the cable still plugged in"):
                device.read(["load"])
            with pytest.raises(DeviceLostError, match=r"cannot be opened"):
                device.read(["load"])

    def test_unplugged_cable_is_reported_while_recording_in_a_rig(self):
        with cell() as device:
            rig = Rig({"cell": device}, device.clock)
            rig.connect()
            blocks = rig.stream("cell", ["load"], 5.0, Stop())
            next(blocks)
            device.far.unplug()
            with pytest.raises(DeviceLostError, match=r"^cell: .*plugged in"):
                list(blocks)
            assert all(report.safe for report in rig.make_safe())
            rig.close()


def speak_in_pounds(device):
    """Let the lines be in another unit, until the device has noticed."""
    device.talker.make = lambda n: line(n).replace(b"kN", b"lbf")
    wait_until(lambda: device._lines._buffer._problem)


class TestInARunOnAnotherRig:
    """A load cell beside the tester: its failure ends the run safely."""

    @pytest.mark.parametrize(
        ("fail", "kind", "message"),
        [
            (speak_in_pounds, DeviceRejectedError, "after the number"),
            (partial(fall_silent, for_s=1.2), DeviceTimeoutError, "no valid line within 1 s"),
        ],
        ids=["another unit", "silence"],
    )
    def test_failed_load_cell_ends_the_run(self, fail, kind, message):
        tester = FakeTester()
        with cell(stale="1 s") as device:
            rig = Rig({"tester": tester, "cell": device}, SimulatedClock())
            rig.connect()

            def spoil(call):
                if call == "set load 1000":
                    fail(device)

            tester.before = spoil
            summary = run_on(rig)
            rig.close()
        assert summary.outcome is Outcome.ERROR
        with pytest.raises(kind, match=f"^cell: .*{message}"):
            raise summary.error
        assert summary.safe
        assert tester.drives_at == {"load": 0.0, "frequency": 0.0}


class TestRecordings:
    def test_recordings_are_gapless(self):
        with cell() as device:
            device.connect(1.0)
            assert device.sample_rate_hz == 200.0
            blocks = list(device.stream(["torque", "load"], 0.6, Stop()))
            torque = np.concatenate([block.channels["torque"] for block in blocks])
            assert len(torque) == 120
            assert np.diff(torque) == pytest.approx(1.0)
            firsts = np.cumsum([0, *(block.samples for block in blocks)])[:-1]
            assert [block.first_sample for block in blocks] == list(firsts)

    def test_recordings_stop_when_asked_to(self):
        with cell() as device:
            device.connect(1.0)
            assert len(list(device.stream(["load"], 10.0, Stop(after=2)))) == 2
            assert device.read(["load"])

    @pytest.mark.parametrize("rate_hz", [100.0, 400.0])
    def test_rate_other_than_declared_is_refused(self, rate_hz):
        with cell(rate_hz=rate_hz) as device:
            device.connect(1.0)
            with pytest.raises(DeviceRejectedError, match=r"lines are lost, or `rate` is wrong"):
                list(device.stream(["load"], 2.0, Stop()))

    def test_silence_ends_a_recording(self):
        with cell(stale="1 s") as device:
            device.connect(1.0)
            blocks = device.stream(["load"], 20.0, Stop())
            next(blocks)
            fall_silent(device, for_s=1.2)
            with pytest.raises(DeviceTimeoutError, match=r"came 1\.2 s ago"):
                list(blocks)

    def test_channel_that_is_not_in_the_lines_is_refused(self):
        with cell() as device:
            device.connect(1.0)
            with pytest.raises(DeviceRejectedError, match=r"'angle'.*load, torque"):
                device.stream(["angle"], 1.0, Stop())


def test_thread_ends_with_the_connection():
    with cell() as device:
        device.connect(1.0)
        names = {thread.name for thread in threading.enumerate()}
        assert f"lines of {device.far.port}" in names
        device.close()
        device.close()
        names = {thread.name for thread in threading.enumerate()}
        assert f"lines of {device.far.port}" not in names
        with pytest.raises(DeviceLostError, match=r"not connected"):
            device.read(["load"])


class TestCommands:
    """An instrument with identification, start and stop commands, or a request for each line."""

    def device(self, far, **changes):
        settings = merged(CELL, port=far.port, rate=None, **changes)
        return instrument("serial_ascii", settings)

    def test_identification_start_and_stop_are_sent(self):
        far = SerialPeer()
        talker = []

        def answer(text):
            if text == "ID":
                return b"ACME LC-5 #77\r\n"
            if text == "GO":
                talker.append(Talker(far))
            if text == "HALT":
                talker[0].quiet.set()
            return SILENCE

        far.talk_to(Lines(answer, b"\r\n"))
        identification = {"query": "ID", "expect": "ACME LC-5.*"}
        device = self.device(far, identification=identification, start="GO", stop="HALT")
        assert device.connect(1.0) == Identity("unknown", "ACME LC-5 #77", "")
        assert device.read(["load"])
        device.close()
        assert talker[0].quiet.wait(60)
        far.close()

    def test_line_that_arrives_before_the_identification_is_ignored(self):
        """The rest of a line before the answer is not a value: 7 N·m could be of 12347 N·m."""

        def answer(text):
            return b"7.000 kN; 7 Nm\r\nACME LC-5\r\n" + line(5) if text == "ID" else SILENCE

        far = SerialPeer(Lines(answer, b"\r\n"))
        device = self.device(far, identification={"query": "ID", "expect": "ACME.*"})
        device.connect(1.0)
        assert device.read(["torque"]) == {"torque": 5.0}
        device.close()
        far.close()

    def test_only_lines_after_the_answer_count(self):
        def answer(text):
            return b"7.000 kN; 7 Nm\r\nACME LC-5\r\n" if text == "ID" else SILENCE

        far = SerialPeer(Lines(answer, b"\r\n"))
        identification = {"query": "ID", "expect": "ACME.*"}
        device = self.device(far, identification=identification, stale="1 s")
        with pytest.raises(DeviceTimeoutError, match="no valid line"):
            device.connect(1.0)
        far.close()

    def test_another_instrument_is_refused(self):
        far = SerialPeer(Lines(lambda _line: b"OTHER 1\r\n", b"\r\n"))
        identification = {"query": "ID", "expect": "ACME.*"}
        device = self.device(far, identification=identification, stale="1 s")
        with pytest.raises(
            DeviceNotFoundError, match=r"no instrument that matches 'ACME\.\*'.*'OTHER 1'"
        ):
            device.connect(1.0)
        far.close()

    def test_each_request_reads_one_line(self):
        numbers = iter(range(100))
        lines = Lines(lambda _line: line(next(numbers)), b"\r\n")
        far = SerialPeer(lines)
        device = self.device(far, request="P")
        device.connect(1.0)
        assert device.read(["torque"]) == {"torque": 1.0}
        assert device.read(["torque"]) == {"torque": 2.0}
        assert lines.heard == ["P", "P", "P"]
        far.say(line(99))
        wait_until(lambda: device._lines._buffer._unsolicited.endswith(b"\n"))
        with pytest.raises(DeviceRejectedError, match=r"99 Nm.* arrived unrequested"):
            device.read(["torque"])
        assert device.read(["torque"]) == {"torque": 3.0}
        device.close()
        far.close()

    def test_missing_answer_to_a_request_times_out(self):
        far = SerialPeer(Lines(lambda _line: SILENCE, b"\r\n"))
        with pytest.raises(DeviceTimeoutError, match=r"nothing came within 0.3 s"):
            self.device(far, request="P", stale="300 ms").connect(1.0)
        far.close()

    def test_answer_that_is_no_measurement_is_refused(self):
        far = SerialPeer(Lines(lambda _line: b"ERR 3\r\n", b"\r\n"))
        with pytest.raises(DeviceRejectedError, match=r"for load, a line is 'ERR 3'"):
            self.device(far, request="P").connect(1.0)
        far.close()


def test_port_in_use_or_missing_is_reported():
    with cell() as device:
        device.connect(1.0)
        second = instrument("serial_ascii", merged(CELL, port=device.far.port))
        with pytest.raises(DeviceNotFoundError, match=r"not in use by another program"):
            second.connect(1.0)
    with pytest.raises(DeviceNotFoundError, match=r"/dev/ttyNONE9 cannot be opened: No such"):
        instrument("serial_ascii", merged(CELL, port="/dev/ttyNONE9")).connect(1.0)


def test_missing_package_names_the_extra(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "serial", None)
    device = instrument("serial_ascii", merged(CELL, port="/dev/ttyUSB0"))
    with pytest.raises(PluginError, match=r"'pyserial' is not installed.*rigrunner\[serial\]"):
        device.connect(1.0)


def test_trial_of_the_plugin_works():
    trial = REGISTRY.find("device", "serial_ascii").record.trial
    device = instrument("serial_ascii", trial, SimulatedClock())
    assert device.connect(1.0).simulated
    assert device.read(["mass"]) == {"mass": pytest.approx(0.01278)}
    blocks = list(device.stream(["mass"], 0.3, Stop()))
    assert sum(block.samples for block in blocks) == 3
    device.close()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"port": "socket://10.0.0.1:4001"}, "port"),
        ({"port": "ttyUSB0"}, "port"),
        ({"termination": "none"}, "a line needs a terminator"),
        ({"channels": {}}, "channels"),
        ({"request": "P"}, "rate is for lines that the instrument sends by itself"),
        ({"simulated": "yes"}, "needs an example"),
        ({"example": "1.0 lbf; 2 Nm"}, "example: for load, a line is .* 'lbf', expected 'kN'"),
        ({"serial": {"parity": "evn"}}, "parity"),
        ({"ignore": "("}, "not a regular expression"),
    ],
)
def test_invalid_settings_are_refused(changes, message):
    settings = merged(CELL, port="/dev/ttyUSB0")
    with pytest.raises((PluginError, DeviceError), match=message):
        instrument("serial_ascii", merged(settings, **changes))
