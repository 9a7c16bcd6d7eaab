from __future__ import annotations

import io

import pytest
from msgspec.structs import replace

from rigrunner.api.events import Alarm, Outcome, RunEnded, RunStarted, Scanned, StepStarted
from rigrunner.cli.durations import clock_text
from rigrunner.cli.progress import shown_progress

WHEN = {"seq": 0, "utc": "2026-01-01T00:00:00Z"}
STARTED = RunStarted(monotonic_s=100.0, run_id="R1", steps=12, estimated_s=200.0, **WHEN)
STEP = StepStarted(
    monotonic_s=150.0, step="main[0]", index=2, action="set", text="set load to 1000 N", **WHEN
)
ALARM = Alarm(monotonic_s=160.0, source="tester", text="no answer", **WHEN)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def show(events, stream, monkeypatch):
    monkeypatch.setattr("sys.stderr", stream)
    with shown_progress() as progress:
        for event in events:
            progress(event)
    return stream.getvalue()


def ended(outcome):
    return RunEnded(monotonic_s=150.0, outcome=outcome, **WHEN)


def test_pipe_gets_one_line_per_step(monkeypatch):
    shown = show([STARTED, STEP, ALARM], io.StringIO(), monkeypatch)
    assert shown.splitlines() == [
        "R1: 12 steps, 3 min 20 s",
        "[ 3/12] set load to 1000 N",
        "alarm: tester: no answer",
    ]


@pytest.mark.parametrize(
    ("outcome", "percent"), [(Outcome.COMPLETED, "100 %"), (Outcome.ABORTED, "25 %")]
)
def test_bar_reaches_100_percent_only_if_the_run_completes(monkeypatch, outcome, percent):
    monkeypatch.setenv("TERM", "xterm")
    shown = show([STARTED, STEP, ended(outcome)], Terminal(), monkeypatch)
    last = [line for line in shown.splitlines() if "%" in line][-1]
    assert percent in last
    assert str(outcome) in last


def test_points_of_a_fast_scan_are_shown_ten_times_a_second(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    fields = {"step": "main[0]", "measurement": "m", "setpoints": {}, "values": {}}
    rows = [Scanned(monotonic_s=151.0, point=point, **fields, **WHEN) for point in range(500)]
    now_s = iter(range(1000))
    monkeypatch.setattr("rigrunner.cli.progress.monotonic", lambda: next(now_s) / 1024)
    shown = show([STARTED, STEP, *rows], Terminal(), monkeypatch)
    last = [line for line in shown.splitlines() if "point" in line][-1]
    assert "point 413: set load to 1000 N" in last  # shown each tenth of a second
    assert show([STARTED, STEP, *rows], io.StringIO(), monkeypatch).count("\n") == 2


def test_long_step_text_leaves_room_for_the_bar(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    long_step = replace(STEP, text=f"Scan tester.load, reading {', '.join(['tester.torque'] * 9)}")
    shown = show([STARTED, long_step], Terminal(), monkeypatch)
    (last, *_) = [line for line in reversed(shown.splitlines()) if "Scan" in line]
    assert "25 %" in last
    assert "━" in last


def test_terminal_shows_alarms(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    assert "no answer" in show([STARTED, ALARM], Terminal(), monkeypatch)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0 s"), (59.6, "1 min 00 s"), (65, "1 min 05 s"), (7800, "2 h 10 min")],
)
def test_durations_in_hours_minutes_and_seconds(seconds, text):
    assert clock_text(seconds) == text
