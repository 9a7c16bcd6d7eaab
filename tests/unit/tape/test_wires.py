"""The exchanges of a wire are replayed in strict order, up to the first difference."""

from __future__ import annotations

import contextlib
import errno
import os
import threading
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import (
    DataError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner.clock import SimulatedClock
from rigrunner.tape.clock import RecordedClock, ReplayedClock
from rigrunner.tape.file import TapeFile
from rigrunner.tape.recording import RecordingWire, Trouble
from rigrunner.tape.replaying import Replay, ReplayWire
from rigrunner.tape.tape import CallClock, Calls

LINES = [
    b'{"seq":0,"ask":"x","answer":1,"took_s":0}', b'{"seq":1,"ask":"x","error":{},"took_s":0}',
    b'{"seq":2,"ask":[],"answer":{"array":1},"took_s":"x"}', b'{"seq":3,', b"[" * 100_000,
    b'{"seq":4,"ask":"x","answer":' + b"[" * 100_000,
]  # fmt: skip
START = datetime(2026, 3, 1, 12, tzinfo=UTC)


def failing(error):
    def perform():
        raise error

    return perform


def not_called():
    raise AssertionError("an instrument was asked")


@pytest.fixture
def path(tmp_path):
    """A tape of three exchanges, the last of which failed."""
    wire = RecordingWire(tmp_path / "press.jsonl", Trouble())
    assert wire.exchange("write FORC 10", lambda: None) is None
    assert wire.exchange("query FORC?", lambda: 9.75) == 9.75
    with pytest.raises(DeviceTimeoutError):
        wire.exchange("query FORC?", failing(DeviceTimeoutError("no answer in 2 s")))
    wire.close()
    return tmp_path / "press.jsonl"


@pytest.fixture
def replay_of():
    tapes = []

    def make(path, replay=None, patience_s=10.0):
        tapes.append(TapeFile(path))
        return ReplayWire(tapes[-1], replay or Replay(), patience_s)

    yield make
    for tape in tapes:
        tape.close()


def test_replay_returns_the_recorded_answers_and_errors(path, replay_of):
    wire = replay_of(path)
    assert wire.exchange("write FORC 10", not_called) is None
    assert (
        wire.unrequested() == f"{path}:2: 2 exchanges are left on the tape that were not asked for"
    )
    assert wire.exchange("query FORC?", not_called) == 9.75
    with pytest.raises(DeviceTimeoutError, match="no answer in 2 s"):
        wire.exchange("query FORC?", not_called)
    assert wire.unrequested() == ""


def test_first_difference_names_location_requests_and_history(path, replay_of):
    replay = Replay()
    replay.hint = "the settings of press are not those of the tape"
    wire = replay_of(path, replay)
    wire.exchange("write FORC 10", not_called)
    with pytest.raises(DeviceRejectedError) as caught:
        wire.exchange("query FORC2?", not_called)
    assert str(caught.value) == (
        f"the replay differs from the tape: {path}:2 has 'query FORC?',"
        " the replay asked for 'query FORC2?',"
        " after 'write FORC 10' (the settings of press are not those of the tape)"
    )


def test_first_difference_ends_all_tapes_of_a_replay(path, replay_of):
    replay = Replay()
    first, second = replay_of(path, replay), replay_of(path, replay)
    with pytest.raises(DeviceRejectedError, match="asked for 'identify', the very first"):
        first.exchange("identify", not_called)
    with pytest.raises(DeviceRejectedError, match=r"the replay ended at .*press.jsonl:1$"):
        second.exchange("write FORC 10", not_called)


def test_request_after_the_end_of_the_tape_is_refused(path, replay_of):
    wire = replay_of(path)
    for request in ("write FORC 10", "query FORC?"):
        wire.exchange(request, not_called)
    with pytest.raises(DeviceTimeoutError):
        wire.exchange("query FORC?", not_called)
    with pytest.raises(DeviceRejectedError) as caught:
        wire.exchange("close", not_called)
    assert str(caught.value) == (
        f"the tape is over at {path}:3, the replay asked for 'close',"
        " after 'write FORC 10', 'query FORC?', 'query FORC?'"
    )


def test_missing_tape_is_over_at_once(tmp_path, replay_of):
    with pytest.raises(DeviceRejectedError, match=r"the tape is over .* the very first"):
        replay_of(tmp_path / "press.jsonl").exchange("connect", not_called)


def test_tape_cut_at_any_byte_has_its_complete_lines(path, tmp_path):
    content = path.read_bytes()
    cut = tmp_path / "cut.jsonl"
    for length in range(len(content) + 1):
        cut.write_bytes(content[:length])
        tape = TapeFile(cut)
        assert len(tape) == content[:length].count(b"\n")
        assert all(tape.entry(seq) is not None for seq in range(len(tape)))
        tape.close()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b"hello\n", "not an exchange"),
        (b'{"seq":0,"ask":"x","answer":1,"took_s":0}\n', "exchange 0 comes twice"),
    ],
)
def test_invalid_line_is_named(path, line, message):
    path.write_bytes(path.read_bytes() + line)
    with pytest.raises(DataError, match=rf"press.jsonl:4: {message}"):
        TapeFile(path)


@given(st.lists(st.binary(max_size=80) | st.sampled_from(LINES), max_size=6))
def test_any_file_is_a_tape_or_a_data_error(tmp_path_factory, lines):
    path = tmp_path_factory.mktemp("any") / "a.jsonl"
    path.write_bytes(b"\n".join(lines))
    with contextlib.suppress(DataError):
        tape = TapeFile(path)
        for seq in range(len(tape)):
            with contextlib.suppress(DataError):
                tape.entry(seq)
        tape.close()


def test_damaged_answer_is_reported_when_it_is_requested(path, replay_of):
    path.write_bytes(path.read_bytes().replace(b"9.75", b"9.7x"))
    wire = replay_of(path)
    wire.exchange("write FORC 10", not_called)
    with pytest.raises(DataError, match=r"press.jsonl:2: not an exchange"):
        wire.exchange("query FORC?", not_called)


def test_full_disk_ends_all_tapes_but_loses_no_answer(tmp_path, monkeypatch):
    trouble = Trouble()
    first, second = (RecordingWire(tmp_path / f"{name}.jsonl", trouble) for name in "ab")
    first.exchange("query A", lambda: 1.0)

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        assert first.exchange("query A", lambda: 2.0) == 2.0
    assert trouble.text == f"{tmp_path / 'a.jsonl'} cannot be written: No space left on device"
    assert second.exchange("query B", lambda: 3.0) == 3.0
    first.close()
    assert [path.name for path in tmp_path.iterdir()] == ["a.jsonl"]
    assert (tmp_path / "a.jsonl").read_bytes().count(b"\n") == 1


def test_partly_written_line_leaves_a_readable_tape(tmp_path, monkeypatch):
    trouble, write = Trouble(), os.write
    wire = RecordingWire(tmp_path / "a.jsonl", trouble)
    wire.exchange("query A", lambda: 1.0)

    def half(descriptor, line, taken=[]):  # noqa: B006  (counts the calls)
        if taken:
            raise OSError(errno.ENOSPC, "No space left on device")
        taken.append(line)
        return write(descriptor, line[: len(line) // 2])

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", half)
        wire.exchange("query A", lambda: 2.0)
    wire.close()
    tape = TapeFile(tmp_path / "a.jsonl")
    assert len(tape) == 1
    tape.close()
    assert "No space left" in trouble.text


def test_unsupported_answer_is_returned_and_reported(tmp_path):
    trouble = Trouble()
    wire = RecordingWire(tmp_path / "a.jsonl", trouble)
    assert wire.exchange("query A", lambda: (1, 2)) == (1, 2)
    wire.close()
    assert trouble.text.endswith("the answer to 'query A': a tuple cannot be kept on tape")


def test_nested_exchanges_are_part_of_the_outer_one(tmp_path, replay_of):
    wire = RecordingWire(tmp_path / "a.jsonl", Trouble())
    clock = RecordedClock(SimulatedClock(START), wire)

    def perform():
        clock.sleep(0.1)
        return wire.exchange("read the rest", lambda: 2) + 1

    assert wire.exchange("query A", perform) == 3
    with pytest.raises(DeviceLostError):
        wire.exchange("query A", failing(DeviceLostError("gone")))
    wire.exchange("query B", lambda: 4)
    wire.close()
    replay_wire = replay_of(tmp_path / "a.jsonl")
    assert replay_wire.exchange("query A", not_called) == 3
    with pytest.raises(DeviceLostError):
        replay_wire.exchange("query A", not_called)
    assert replay_wire.exchange("query B", not_called) == 4
    assert replay_wire.unrequested() == ""


def test_unanswered_request_is_recorded_and_times_out_in_replay(tmp_path, replay_of):
    wire = RecordingWire(tmp_path / "a.jsonl", Trouble())
    answer, requested = threading.Event(), threading.Event()

    def hang():
        requested.set()
        answer.wait(10)

    thread = threading.Thread(target=lambda: wire.exchange("query A", hang))
    thread.start()
    assert requested.wait(10)
    assert wire.exchange("make safe", lambda: 0.0) == 0.0  # from another thread, as the rig does
    wire.close()
    answer.set()
    thread.join()
    replay = Replay()
    replay_wire = replay_of(tmp_path / "a.jsonl", replay, patience_s=0.0)
    replay.over.set()  # the run no longer waits
    with pytest.raises(DeviceTimeoutError, match="query A: it was never answered"):
        replay_wire.exchange("query A", not_called)
    assert replay_wire.exchange("make safe", not_called) == 0.0


@pytest.mark.parametrize(("patience_s", "waits"), [(0.05, True), (10.0, False)])
def test_late_answer_is_delayed_in_replay(path, patience_s, waits):
    class Wait:
        seconds = None

        def wait(self, seconds):
            self.seconds = seconds

    text = path.read_text().splitlines()
    text[0] = text[0][: text[0].index('"took_s"')] + '"took_s":0.25}'
    path.write_text("\n".join(text) + "\n")
    replay, tape = Replay(), TapeFile(path)
    replay.over = Wait()
    ReplayWire(tape, replay, patience_s).exchange("write FORC 10", not_called)
    tape.close()
    assert replay.over.seconds == (0.25 if waits else None)


def test_replayed_clock_returns_the_recorded_times(tmp_path, replay_of):
    plain = SimulatedClock(START)
    wire = RecordingWire(tmp_path / "clock.jsonl", Trouble())

    def use(clock):
        before = [clock.monotonic_s(), clock.utc()]
        clock.sleep(0.1)
        return [*before, clock.monotonic_s(), clock.utc()]

    plain.sleep(1 / 3)
    times = use(RecordedClock(plain, wire))
    wire.close()
    clock = ReplayedClock(replay_of(tmp_path / "clock.jsonl"), START)
    assert use(clock) == times
    clock.sleep(2.0)  # the tape is over: the clock advances by the sleep
    assert clock.monotonic_s() == times[2] + 2.0
    assert (clock.utc() - times[3]).total_seconds() == 2.0


def test_clock_difference_is_reported_by_the_next_exchange(tmp_path, path, replay_of):
    wire = RecordingWire(tmp_path / "clock.jsonl", Trouble())
    RecordedClock(SimulatedClock(START), wire).utc()
    wire.close()
    replay = Replay()
    clock = ReplayedClock(replay_of(tmp_path / "clock.jsonl", replay), START)
    clock.sleep(0.5)
    with pytest.raises(DeviceRejectedError, match=r"clock.jsonl:1 has 'clock: date and time'"):
        replay_of(path, replay).exchange("write FORC 10", not_called)


def test_only_clock_reads_of_a_device_call_are_recorded(tmp_path):
    wire, plain, calls = RecordingWire(tmp_path / "a", Trouble()), SimulatedClock(START), Calls()
    clock = CallClock(RecordedClock(plain, wire), plain, calls)
    listener_times = []

    def listen():
        listener_times.append(clock.monotonic_s())
        clock.sleep(1.0)
        listener_times.append(clock.utc())

    def call():
        thread = threading.Thread(target=listen)
        thread.start()
        thread.join()
        return clock.monotonic_s()

    assert calls.exchange("connect", call) == 1.0
    assert clock.monotonic_s() == 1.0
    wire.close()
    assert len(listener_times) == 2
    assert (tmp_path / "a").read_text().count("\n") == 1


def test_replayed_errors_keep_their_hints(tmp_path, replay_of):
    wire = RecordingWire(tmp_path / "a.jsonl", Trouble())
    with pytest.raises(DeviceLostError):
        wire.exchange("read", failing(DeviceLostError("unplugged", hint="see the cable")))
    wire.close()
    with pytest.raises(DeviceLostError) as caught:
        replay_of(tmp_path / "a.jsonl").exchange("read", not_called)
    assert str(caught.value) == "unplugged (see the cable)"


def test_tapes_are_never_overwritten(path):
    trouble = Trouble()
    wire = RecordingWire(path, trouble)
    before = path.read_bytes()
    assert wire.exchange("query A", lambda: 1) == 1
    assert "File exists" in trouble.text
    assert path.read_bytes() == before
    assert Path(path).exists()
