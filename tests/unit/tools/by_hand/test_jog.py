"""Jogging of one device: limits, interlocks, the log, and the safe end."""

from __future__ import annotations

import dataclasses
import io
import json
import re
import threading

import pytest

from helpers_cli import call
from helpers_devices import FakeTester
from helpers_workflow import station_file
from rigrunner.api.errors import (
    AbortedError,
    DataError,
    DeviceError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    ExitCode,
    UsageError,
)
from rigrunner.cli.jogging import run_prompt
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.tools.by_hand.jog import jogging
from rigrunner.tools.by_hand.station import ready_station

ORDER = "order: [tester.frequency, tester.load]"
OVERHEATED = (
    "  interlocks:\n    - {name: overheated, channel: tester.temperature, above: 60 °C,"
    " every: 1 s, debounce: 2 s}\n"
)


def station(folder, *changes):
    """Return the simulated station without its interlock: a fake has no temperature."""
    return station_file(folder, (OVERHEATED, ""), *changes)


def locked(*interlocks):
    return ORDER, "\n    - ".join([f"{ORDER}\n  interlocks:", *interlocks])


def by_hand(folder, tester, *changes, role="tester", stop=None, **others):
    ready = ready_station(station(folder, *changes))
    ready = dataclasses.replace(ready, devices={**ready.devices, "tester": tester, **others})
    return jogging(ready, role, folder / "jog.log", stop or threading.Event())


def failing(call, error):
    def before(request):
        if request.startswith(call):
            raise error

    return before


def log_of(folder):
    return (folder / "jog.log").read_text(encoding="utf-8")


def test_drive_is_set_read_back_and_made_safe(tmp_path):
    tester = FakeTester()
    with by_hand(tmp_path, tester) as jog:
        assert jog.set("frequency", "5 Hz") == 5.0
        assert jog.read_backs() == {"load": 7.0, "frequency": 5.0}
        assert jog.read(["load"]) == {"load": 1000.0}
    assert "set frequency 5" in tester.calls
    assert tester.calls[-1] == "close"
    assert set(tester.drives_at.values()) == {0.0}
    log = log_of(tmp_path)
    assert "jog: note: tester of station simulated" in log
    assert "set frequency 5 Hz: reads back 5 Hz" in log
    assert "read load 1000 N" in log
    assert "tester is safe: read back" in log


@pytest.mark.parametrize(
    ("drive", "text", "message"),
    [
        ("frequency", "36 Hz", "frequency: 36 Hz is out of range"),
        ("frequency", "-1 Hz", "frequency: -1 Hz is out of range"),
        ("frequency", "5 N", "'5 N' is a force, not a frequency"),
        ("frequency", "5", "frequency: "),
        ("frequency", "nan Hz", "frequency: "),
        ("frequnecy", "5 Hz", "did you mean 'frequency'"),
    ],
)
def test_invalid_set_is_refused_before_sending(tmp_path, drive, text, message):
    tester = FakeTester()
    with by_hand(tmp_path, tester) as jog:
        before = list(tester.calls)
        with pytest.raises(UsageError, match=message):
            jog.set(drive, text)
        assert tester.calls == before


def test_narrower_limits_of_the_station_are_enforced(tmp_path):
    narrow = (ORDER, f"{ORDER}\n  drives: {{tester.frequency: {{max: 10 Hz}}}}")
    tester = FakeTester()
    with by_hand(tmp_path, tester, narrow) as jog:
        assert jog.set("frequency", "10 Hz") == 10.0
        with pytest.raises(UsageError) as caught:
            jog.set("frequency", "11 Hz")
    assert str(caught.value) == "frequency: 11 Hz is out of range (0 to 10 Hz)"


def test_forbidden_combination_of_drives_is_refused(tmp_path):
    allowed = (
        "{tester.frequency: 35 Hz, tester.load: 1 kN}, {tester.frequency: 5 Hz, tester.load: 3 kN}"
    )
    together = ORDER, f"{ORDER}\n  combinations:\n    - allowed: [{allowed}]"
    tester = FakeTester()
    with by_hand(tmp_path, tester, together) as jog:
        jog.set("load", "3 kN")
        with pytest.raises(DeviceRejectedError, match="cannot be set to 30 Hz with"):
            jog.set("frequency", "30 Hz")
        assert "set frequency 30" not in tester.calls


@pytest.mark.parametrize("error", [DeviceLostError("unplugged"), DeviceTimeoutError("silent")])
@pytest.mark.parametrize("at", ["set frequency", "read_back frequency"])
def test_device_error_makes_the_rig_safe_before_it_is_raised(tmp_path, at, error):
    tester = FakeTester(before=failing(at, error))
    with by_hand(tmp_path, tester) as jog:
        with pytest.raises(type(error)):
            jog.set("frequency", "5 Hz")
        assert tester.calls[-1] == "make_safe"
    assert "ALARM jog: set frequency 5 Hz: tester: " in log_of(tmp_path)


def test_drive_that_does_not_arrive_makes_the_rig_safe(tmp_path):
    tester = FakeTester(read_back_offset=2.0)
    with pytest.raises(DeviceError) as caught, by_hand(tmp_path, tester) as jog:
        jog.set("frequency", "5 Hz")
    assert "was set to 5 Hz but reads back 7 Hz" in str(caught.value)
    assert caught.value.__notes__ == [
        "the rig is not safe: tester: frequency reads back 2 Hz, safe is 0 Hz"
    ]


def test_rig_that_is_unsafe_at_the_end_is_an_error(tmp_path):
    tester = FakeTester()
    with (
        pytest.raises(DeviceError, match="the rig is not safe: tester: "),
        by_hand(tmp_path, tester),
    ):
        tester.read_back_offset = 5.0
    assert "NOT SAFE tester" in log_of(tmp_path)


@pytest.mark.parametrize("end", [KeyboardInterrupt(), AbortedError("stopped by SIGTERM")])
def test_stop_with_an_unsafe_rig_is_an_error(tmp_path, end):
    tester = FakeTester(before=failing("set frequency", end), read_back_offset=5.0)
    with pytest.raises(DeviceError) as caught, by_hand(tmp_path, tester) as jog:
        jog.set("frequency", "5 Hz")
    assert caught.value.__cause__ is end
    assert caught.value.message.endswith(
        "; the rig is not safe: tester: frequency reads back 5 Hz, safe is 0 Hz"
    )


@pytest.mark.parametrize("interrupted", ["set frequency", "read load", "read_back"])
def test_ctrl_c_makes_the_rig_safe(tmp_path, interrupted):
    tester = FakeTester(before=failing(interrupted, KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt), by_hand(tmp_path, tester) as jog:
        jog.read(["load"]), jog.set("frequency", "5 Hz")
    assert tester.calls[-2:] == ["make_safe", "close"]


def test_tripped_interlock_makes_safe_and_ends_jogging(tmp_path):
    lock = locked("{name: pressed, channel: tester.load, above: 900 N, every: 1 s}")
    tester = FakeTester()
    with (
        pytest.raises(AbortedError, match=r"tester\.load is 1000 N"),
        by_hand(tmp_path, tester, lock) as jog,
    ):
        jog.set("frequency", "5 Hz")
    assert "set frequency 5" not in tester.calls
    assert tester.calls[-2:] == ["make_safe", "close"]
    assert "ALARM interlock pressed" in log_of(tmp_path)


def test_pausing_interlock_blocks_drives_until_it_clears(tmp_path):
    lock = locked("{name: pressed, channel: tester.load, above: 900 N, every: 1 s, does: pause}")
    tester = FakeTester()
    with by_hand(tmp_path, tester, lock) as jog:
        with pytest.raises(DeviceRejectedError, match="nothing is set until it clears"):
            jog.set("frequency", "5 Hz")
        tester.read_back_offset = -500.0  # the fake now reads 500 N
        with pytest.raises(DeviceError):
            jog.set("frequency", "5 Hz")  # now it is sent, but not read back
        tester.read_back_offset = 0.0
    assert "set frequency 5" in tester.calls


def test_stop_token_ends_jogging(tmp_path):
    stop, tester = threading.Event(), FakeTester()
    with by_hand(tmp_path, tester, stop=stop) as jog:
        stop.set()
        with pytest.raises(AbortedError):
            jog.check_interlocks()
    assert tester.calls[-2:] == ["make_safe", "close"]


def test_zero_is_a_mean_that_is_subtracted_from_readings(tmp_path):
    with by_hand(tmp_path, FakeTester()) as jog:
        # samples of the fake: 1000 + 1e-6 k, k from 0 to 999 in the second of a zero
        assert jog.zero("load") == pytest.approx(1000 + 1e-6 * 499.5, abs=1e-9)
        assert jog.read(["load"])["load"] == pytest.approx(-1e-6 * 499.5, abs=1e-9)
        assert jog.zero("load") == pytest.approx(1000 + 1e-6 * 499.5, abs=1e-9)


def test_watch_reads_at_intervals(tmp_path):
    tester = FakeTester()
    with by_hand(tmp_path, tester) as jog:
        assert list(jog.watch("load", 1.0)) == [1000.0] * 5
        with pytest.raises(UsageError, match="there is no channel 'laod'"):
            list(jog.watch("laod", 1.0))


def test_unwritable_log_prevents_jogging(tmp_path):
    (tmp_path / "jog.log").mkdir()
    tester = FakeTester()
    with (
        pytest.raises(DataError, match=r"cannot write the log .*Is a directory"),
        by_hand(tmp_path, tester),
    ):
        pass
    assert tester.calls == []


def test_failed_log_ends_jogging_with_a_safe_rig(tmp_path, monkeypatch):
    tester = FakeTester()

    def full(*_):
        raise OSError(28, "No space left on device")

    with by_hand(tmp_path, tester) as jog:
        with monkeypatch.context() as patch:
            patch.setattr("rigrunner.run.log.RunLog.__call__", full)
            with pytest.raises(DataError, match=r"log .* No space"):
                jog.set("frequency", "5 Hz")
        assert set(tester.drives_at.values()) == {0.0}
    assert tester.calls[-1] == "close"
    assert set(tester.drives_at.values()) == {0.0}


def test_only_required_devices_are_connected(tmp_path):
    second_device = ("devices:\n", "devices:\n  other: {type: t, plugin: swing_tester_sim}\n")
    lock = locked("{name: hot, channel: tester.load, above: 9 kN, every: 1 s}")
    tester, second = FakeTester(), FakeTester()
    with by_hand(tmp_path, tester, second_device, other=second):
        pass
    assert second.calls == []
    tester = FakeTester()
    with by_hand(tmp_path, tester, second_device, lock, other=second, role="other"):
        pass
    assert second.calls[0] == tester.calls[0] == "connect"


def test_unknown_role_gets_a_suggestion(tmp_path):
    result = call("jog", station(tmp_path), "testre", "--read", "torque")
    assert result.code == ExitCode.USAGE
    assert "there is no device in the role 'testre'" in result.err
    assert "did you mean 'tester'?" in result.err


def jog_once(folder, *arguments):
    return call("jog", station_file(folder), "tester", "--log", folder / "jog.log", *arguments)


def test_command_sets_and_reads_once(tmp_path):
    result = jog_once(tmp_path, "--set", "frequency=5 Hz", "--read", "temperature")
    assert result.code == ExitCode.PASS
    assert re.fullmatch(r"frequency reads back 5 Hz\ntemperature 2[23][.]\d+ °C\n", result.out)
    assert "tester is safe: read back tester.frequency 0 Hz, tester.load 0 N" in result.err
    document = json.loads(jog_once(tmp_path, "--set", "frequency=5 Hz", "--json").out)
    assert document == {"set": {"frequency": 5.0}, "read": {}}


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("--set", "frequency=50 Hz"), ExitCode.USAGE, "out of range (0 to 35 Hz)"),
        (("--set", "frequency"), ExitCode.USAGE, "'--set frequency' gives no input"),
        (("--read", "torqeu"), ExitCode.USAGE, "did you mean 'torque'?"),
        (("--log", "/proc/x"), ExitCode.DATA, "cannot write the log /proc/x"),
    ],
)
def test_invalid_options_are_refused(tmp_path, arguments, code, message):
    result = jog_once(tmp_path, *arguments)
    assert result.code == code
    assert message in result.err


def test_prompt_continues_after_mistakes_and_ends_safe(tmp_path, monkeypatch):
    lines = (
        "set frequency 5 Hz\nset load 99 kN\nraed\nset\nwatch\nzero\nwatch torque 1 s\nread load\n"
    )
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    result = jog_once(tmp_path)
    assert result.code == ExitCode.PASS
    assert "frequency reads back 5 Hz\n" in result.out
    assert "5 readings in 1 s" in result.out
    for words in (
        "load: 99 kN is out of range", "did you mean 'read'?",
        "'set' needs a drive and a value", "watch what?",
        "zero what?",
    ):  # fmt: skip
        assert words in result.err
    assert result.err.rstrip().endswith("read back tester.frequency 0 Hz, tester.load 0 N")


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ("soon", "watch: 'soon' is not a number with a unit"),
        ("5 Hz", "watch: '5 Hz' is a frequency"),
        ("0 s", "watch: got 0 s, expected more than 0 s"),
        ("-1 s", "watch: got -1 s, expected more than 0 s"),
    ],
)
def test_invalid_watch_time_does_not_end_the_prompt(tmp_path, monkeypatch, time, message):
    lines = f"set frequency 5 Hz\nwatch torque {time}\npositions\nwatch torque 1e-10 s\n"
    monkeypatch.setattr("sys.stdin", io.StringIO(lines))
    result = jog_once(tmp_path)
    assert result.code == ExitCode.PASS, result.err
    assert message in result.err
    assert "The rig was made safe" not in result.err
    assert result.out.count("frequency reads back 5 Hz\n") == 2  # still at 5 Hz
    assert "1 readings in 1e-10 s" in result.out


@pytest.mark.parametrize(
    ("offset", "message"),
    [
        (0.0, "The rig was made safe.\n"),
        (5.0, "THE RIG IS NOT SAFE: tester: frequency reads back 5 Hz, safe is 0 Hz. Stop it by"),
    ],
)
def test_prompt_reports_whether_the_rig_is_safe_after_an_error(
    tmp_path, monkeypatch, capsys, offset, message
):
    error = DeviceLostError("unplugged")
    tester = FakeTester(before=failing("set frequency", error), read_back_offset=offset)
    monkeypatch.setattr("sys.stdin", io.StringIO("set frequency 5 Hz\n"))
    with by_hand(tmp_path, tester) as jog, stop_on_signals() as stop:
        run_prompt(jog, stop)
        tester.read_back_offset = 0.0
    assert message in capsys.readouterr().err


def test_jogging_can_be_recorded_and_replayed(tmp_path):
    options = ("--set", "frequency=5 Hz", "--read", "torque")
    first = jog_once(tmp_path, *options, "--record", tmp_path / "tape")
    replayed = jog_once(tmp_path, *options, "--replay", tmp_path / "tape")
    assert (replayed.code, replayed.out) == (first.code, first.out)
    different = jog_once(tmp_path, "--set", "frequency=6 Hz", "--replay", tmp_path / "tape")
    assert different.code == ExitCode.DEVICE
    assert "has 'set frequency 5.0', the replay asked for 'set frequency 6.0'" in different.err
