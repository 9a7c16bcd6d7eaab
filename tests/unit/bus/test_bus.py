from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers_devices import Listener
from rigrunner.api.events import (
    Alarm,
    Note,
    RunEnded,
    RunStarted,
)
from rigrunner.bus import Bus, Emitter, EventStamp
from rigrunner.clock import SimulatedClock, utc_text


def failing(_event: object) -> None:
    raise RuntimeError("the screen is gone")


@pytest.fixture
def clock() -> SimulatedClock:
    return SimulatedClock(datetime(2026, 3, 1, tzinfo=UTC))


def start(emit: Emitter) -> None:
    emit(RunStarted, run_id="r", steps=1, estimated_s=2.0)


def test_stamp_numbers_and_times_events(clock):
    stamp = EventStamp(clock)
    first = stamp(Alarm, source="a", text="b")
    clock.sleep(1.5)
    second = stamp(Alarm, source="a", text="b")
    assert (first.seq, first.monotonic_s, first.utc) == (0, 0.0, "2026-03-01T00:00:00.000Z")
    assert (second.seq, second.monotonic_s, second.utc) == (1, 1.5, "2026-03-01T00:00:01.500Z")


def test_failing_guarded_sink_is_dropped_with_alarm(clock):
    critical, guarded = Listener(), Listener()
    emit = Emitter(Bus([critical], [failing, guarded]), clock)
    start(emit)
    start(emit)
    kinds = [type(event) for event in critical.events]
    assert kinds == [RunStarted, Alarm, RunStarted]
    assert critical.events == guarded.events
    assert "failing failed and was dropped: RuntimeError: the screen is gone" in (
        critical.events[1].text
    )
    assert [event.seq for event in critical.events] == [0, 1, 2]


def test_failing_critical_sink_raises_once_and_gets_no_more_events(clock):
    def full(_event: object) -> None:
        calls.append("full")
        raise OSError("disk full")

    calls: list[str] = []
    other, guarded = Listener(), Listener()
    emit = Emitter(Bus([full, other], [guarded]), clock)
    with pytest.raises(OSError, match="disk full"):
        start(emit)
    start(emit)
    assert calls == ["full"]
    assert len(other.events) == len(guarded.events) == 2


def test_critical_sinks_get_events_before_guarded_sinks(clock):
    calls: list[str] = []
    bus = Bus([lambda _: calls.append("file")], [lambda _: calls.append("screen")])
    Emitter(bus, clock)(RunEnded, outcome="completed")
    assert calls == ["file", "screen"]


def test_clock_set_back_raises_one_alarm_but_small_correction_none():
    class Machine(SimulatedClock):
        back_s = 0.0

        def utc(self):
            return super().utc() - timedelta(seconds=self.back_s)

    clock, listener = Machine(datetime(2026, 3, 1, tzinfo=UTC)), Listener()
    emit = Emitter(Bus([listener]), clock)
    start(emit)
    for clock.back_s in (0.5, 3600.0, 3600.0):
        clock.sleep(0.001)
        start(emit)
    alarms = [event.text for event in listener.events if isinstance(event, Alarm)]
    assert len(alarms) == 1
    assert len(listener.events) == 4 + len(alarms)
    assert "set back from 2026-02-28T23:59:59.501Z to 2026-02-28T23:00:00.002Z" in alarms[0]


@given(
    st.integers(0, 999_999),
    st.lists(st.sampled_from([0.0, 1e-7, 4e-7, 1e-6, 7e-5, 3e-4, 0.0013, 0.999]), max_size=40),
)
def test_utc_of_event_is_that_of_clock(microsecond, passed):
    clock = SimulatedClock(datetime(2026, 3, 1, 23, 59, 59, microsecond, tzinfo=UTC))
    stamp = EventStamp(clock)
    for seconds in passed:
        clock.sleep(seconds)
        assert stamp(Note, step="s", text="t").utc == utc_text(clock.utc())


def test_restarted_monotonic_clock_rereads_utc(clock):
    times = iter([5.0, 1.0])
    clock.monotonic_s = lambda: next(times)
    stamp = EventStamp(clock)
    stamp(Note, step="s", text="t")
    clock.utc = lambda: datetime(2026, 3, 1, 0, 1, tzinfo=UTC)
    assert stamp(Note, step="s", text="t").utc == "2026-03-01T00:01:00.000Z"
