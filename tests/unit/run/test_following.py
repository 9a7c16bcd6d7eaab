"""What analyses show during a run."""

from __future__ import annotations

import threading
from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

from helpers_waiting import wait_until
from rigrunner.api.data import Block, RunData
from rigrunner.api.events import Samples, StepEnded, StepStarted
from rigrunner.api.figures import Axis, Curve
from rigrunner.api.findings import Findings
from rigrunner.registry import load_registry
from rigrunner.run import following
from rigrunner.run.following import Following

STAMP = {"seq": 0, "monotonic_s": 0.0, "utc": "2026-01-05T10:00:00+00:00"}
STEP = {"step": "main[0].record", "index": 0, "action": "record"}
VALUES = np.arange(40.0) ** 2
ZERO, CORRECTION = 3.0, 0.5


def settings_of(**more):
    return {"of": "meter.voltage", "per": "load.current",
            "result": {"name": "voltage", "symbol": "U", "unit": "mV"}, **more}  # fmt: skip


def recording_events(name, current, values):
    """Yield the events of a recording, in blocks of seven."""
    units = {"load.current": "A", "meter.voltage": "V"}
    yield StepStarted(**STAMP, **STEP, text="", recording=name, units=units,
                      setpoints={"load.current": current})  # fmt: skip
    for first in range(0, len(values), 7):
        channels = {"meter.voltage": values[first : first + 7]}
        yield Samples(**STAMP, recording=name, block=Block(100.0, first, 0.0, channels))
    yield StepEnded(**STAMP, **STEP, ok=True, recording=name)


class Screen:
    def __init__(self):
        self.shown = []

    def __call__(self, findings, *, is_whole):
        self.shown.append((findings, is_whole))


def run_of(**instruments):
    """Return a run of which only the instruments are known."""
    values = dict.fromkeys(field.name for field in fields(RunData))
    return RunData(**values | {"instruments": instruments, "zeros": {}, "recordings": ()})


def follow_run(folds, instruments=()):
    screen = Screen()
    follow = Following(folds, lambda: run_of(**dict(instruments)), screen)
    zeros = {"meter.voltage": ZERO}
    follow(StepEnded(**STAMP, step="zero", index=0, action="zero", ok=True, values=zeros))
    for event in (*recording_events("1", 1.0, VALUES), *recording_events("2", 2.0, 2 * VALUES)):
        follow(event)
    return screen.shown


@pytest.mark.parametrize(
    ("statistic", "expected"),
    [
        ("mean", np.mean),
        ("maximum", np.max),
        ("range", np.ptp),
        ("rms", lambda values: np.sqrt(np.mean(values**2))),
        ("standard_deviation", lambda values: np.std(values, ddof=1)),
    ],
)
def test_running_statistic_covers_all_readings_minus_zero(statistic, expected):
    fold = load_registry().live("readings", settings_of(statistic=statistic))
    screens = follow_run([("readings", fold)])
    findings, is_whole = screens[-1]
    assert is_whole
    places = [result.place for result in findings.results]
    assert places == ["load.current = 1 A", "load.current = 2 A"]
    for result, values in zip(findings.results, (VALUES - ZERO, 2 * VALUES - ZERO), strict=True):
        assert result.estimate.value == pytest.approx(1000 * expected(values))
        assert np.isnan(result.estimate.u)
        assert result.readings == 40
    (figure,) = findings.figures
    assert [round(point.x, 6) for point in figure.series[0].points] == [
        0.07, 0.14, 0.21, 0.28, 0.35, 0.4,
    ]  # fmt: skip
    first = 2 * VALUES[:7] - ZERO
    assert figure.series[0].points[0].y == pytest.approx(1000 * expected(first))


def test_live_readings_are_corrected_as_in_analysis():
    corrected = SimpleNamespace(corrected=lambda values, zero: values - zero - CORRECTION)
    fold = load_registry().live("readings", settings_of())
    (findings, _) = follow_run([("readings", fold)], {"meter.voltage": corrected}.items())[-1]
    assert findings.results[0].estimate.value == pytest.approx(
        1000 * (VALUES.mean() - ZERO - CORRECTION)
    )


def test_failing_live_analysis_is_dropped_with_a_note():
    class Broken:
        def begin(self, *_):
            raise ZeroDivisionError("by a stranger")

    fold = load_registry().live("readings", settings_of())
    findings, _ = follow_run([("broken", Broken()), ("readings", fold)])[-1]
    assert len(findings.results) == 2
    assert findings.notes == ("broken is shown no more: ZeroDivisionError: by a stranger",)


def test_curve_of_long_recording_has_limited_points():
    fold = load_registry().live("readings", settings_of())
    screen = Screen()
    follow = Following([("r", fold)], run_of, screen)
    for event in recording_events("1", 1.0, np.zeros(7 * 5000)):
        follow(event)
    findings, _ = screen.shown[-1]
    assert 100 < len(findings.figures[0].series[0].points) <= 400


class Ramp:
    """A live analysis that draws each block, and keeps what it got when a recording began."""

    def __init__(self):
        self.recordings = []

    def begin(self, recording, run):
        self.recordings.append((recording.name, recording.setpoints, dict(run.zeros)))

    def take(self, block):
        values = block.channels["meter.voltage"]
        end_s = (block.first_sample + len(values) - 2) / block.rate_hz
        at = np.arange(len(values))
        return [Curve(title="r", x=Axis("n"), y=Axis("U"), at=at, series={"": values}, end_s=end_s)]

    def findings(self):
        return Findings()


def test_curves_are_drawn_per_block_with_time_of_completion():
    curves, fold = [], Ramp()
    follow = Following([("ramp", fold)], run_of, Screen(), lambda *curve: curves.append(curve))
    follow(StepEnded(**STAMP, step="zero", index=0, action="zero", ok=True, values={"a.b": 2.0}))
    for event in recording_events("1", 1.0, VALUES):
        follow(event)
    assert fold.recordings == [("1", {"load.current": 1.0}, {"a.b": 2.0})]
    assert [name for name, *_ in curves] == ["1"] * 6
    assert np.concatenate([curve.series[""] for _, curve, _ in curves]).tolist() == VALUES.tolist()
    # the event is as late as the last sample of its block, and the curve ended two samples before
    assert [at for *_, at in curves] == pytest.approx([-0.02] * 6)


def test_unrecorded_samples_are_drawn_but_enter_no_result():
    curves, screen, fold = [], Screen(), load_registry().live("readings", settings_of())
    follow = Following(
        [("ramp", Ramp()), ("readings", fold)], run_of, screen, lambda *curve: curves.append(curve)
    )
    for event in (*recording_events("1", 1.0, VALUES), *recording_events("", 2.0, VALUES)):
        follow(event)
    assert [name for name, *_ in curves] == ["1"] * 6 + [""] * 6
    assert {result.place for findings, _ in screen.shown for result in findings.results} == {
        "load.current = 1 A"
    }


@pytest.mark.parametrize(
    ("took_s", "draws", "shows"), [(1.0, True, 0), (0.01, True, 2), (1.0, False, 2)]
)
def test_slow_findings_do_not_delay_curves_at_end_of_recording(monkeypatch, took_s, draws, shows):
    """Both recordings are shorter than the calculation of their findings."""
    now_s = 100.0

    class Slow(Ramp):
        def findings(self):
            nonlocal now_s
            now_s += took_s
            return Findings()

    monkeypatch.setattr(following, "monotonic", lambda: now_s)
    screen = Screen()
    draw = (lambda *_: None) if draws else None
    follow = Following([("r", Slow())], run_of, screen, draw)
    for event in (*recording_events("1", 1.0, VALUES), *recording_events("2", 2.0, VALUES)):
        follow(event)
    assert sum(is_whole for _, is_whole in screen.shown) == shows
    assert len(screen.shown) == 1 + shows


class Snapshots(Ramp):
    """A live analysis whose snapshots are analysed once `may` is set."""

    def __init__(self, may):
        super().__init__()
        self.may, self.taken, self.blocks = may, 0, 0

    def take(self, block):
        self.blocks += 1
        return super().take(block)

    def snapshot(self):
        self.taken += 1
        blocks = self.blocks

        def make():
            assert self.may.wait(60.0)
            return Findings(notes=(f"of {blocks} blocks",))

        return make


def test_curves_are_drawn_while_snapshot_is_analysed():
    curves, screen, fold = [], Screen(), Snapshots(threading.Event())
    follow = Following([("s", fold)], run_of, screen, lambda *curve: curves.append(curve))
    for event in recording_events("1", 1.0, VALUES):
        follow(event)
    assert (len(curves), fold.taken, screen.shown) == (6, 1, [])
    fold.may.set()
    wait_until(lambda: screen.shown)
    assert [findings.notes for findings, _ in screen.shown] == [("of 1 blocks",)]


def test_failing_snapshot_is_dropped_with_a_note():
    class Broken(Ramp):
        def snapshot(self):
            return lambda: 1 / 0

    screen, fold = Screen(), load_registry().live("readings", settings_of())
    folds = [("broken", Broken()), ("readings", fold)]
    follow = Following(folds, run_of, screen, lambda *_: None)
    for event in recording_events("1", 1.0, VALUES):
        follow(event)
        wait_until(lambda: not (follow._thread and follow._thread.is_alive()))
    findings, _ = screen.shown[-1]
    assert findings.notes == ("broken is shown no more: ZeroDivisionError: division by zero",)
    assert [result.place for result in findings.results] == ["load.current = 1 A"]


def test_no_snapshot_is_taken_without_drawing():
    fold = Snapshots(threading.Event())
    follow = Following([("s", fold)], run_of, Screen())
    for event in recording_events("1", 1.0, VALUES):
        follow(event)
    assert fold.taken == 0
