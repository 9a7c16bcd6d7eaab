"""The state of a run, as the screen shows it."""

from __future__ import annotations

import itertools
import json
from math import nan

import numpy as np
import pytest

from e2e.helpers_panel import parse_frame
from rigrunner.api.data import Block
from rigrunner.api.events import (
    Alarm,
    InterlockCleared,
    InterlockTripped,
    Intervention,
    MadeSafe,
    Outcome,
    RunEnded,
    RunStarted,
    Samples,
    Scanned,
    StepEnded,
    StepStarted,
)
from rigrunner.api.figures import Axis, Curve
from rigrunner.api.findings import Findings, MeasurementResult, ResultDefinition
from rigrunner.api.quantity import Estimate
from rigrunner_panel.live.story import UNKEPT, Story
from rigrunner_panel.process.messages import (
    Analysed,
    Drawn,
    Ended,
    Failed,
    LiveFindings,
    Show,
    Values,
)
from rigrunner_panel.view.board import SECTIONS, Board
from rigrunner_panel.view.manual import DriveView, ManualView
from rigrunner_panel.view.sections import (
    ChannelView,
    Finished,
    JobView,
    LiveView,
    PauseView,
    PlanView,
    Preflight,
    PreflightItem,
    PromptView,
    StepView,
)

numbers = itertools.count()


class NoLinks:
    def picture(self, path):
        return f"/api/v1/pictures/{path}"

    def run_links(self, _run):
        return ()


def step(index, point, **sets):
    return StepView(
        index=index, path=f"main[{index}]", phase="main", action="record", text="",
        point=point, estimated_s=10.0, sets=sets,
    )  # fmt: skip


PLAN = PlanView(estimated_s=40.0, steps=(step(0, ""), step(1, "a"), step(2, "a"), step(3, "b")))


def event(kind, **fields):
    common = {"seq": next(numbers), "monotonic_s": 0.0, "utc": "2026"}
    return kind(**{**common, **fields})


def show_plan(plan):
    return Show({"plan": plan})


def started(index, recording=""):
    common = {"step": f"main[{index}]", "index": index, "action": "record", "text": f"step {index}"}
    return event(StepStarted, **common, recording=recording)


def ended(index, *, ok=True, action="record", **more):
    return event(StepEnded, step=f"main[{index}]", index=index, action=action, ok=ok, **more)


@pytest.fixture
def board():
    return Board()


@pytest.fixture
def story(board):
    job = JobView(kind="run", procedure="p", station="s", realtime=False)
    story = Story(board, job, NoLinks())
    story.take(show_plan(PLAN))
    return story


PAUSE = PauseView(
    step="main[1]",
    point="a",
    reason="pause requested",
    moving=(),
    choices=("resume", "abort"),
)
STARTED = {"run_id": "R1", "steps": 4, "estimated_s": 40.0}


def test_phase_follows_the_messages(board, story):
    def after(message):
        story.take(message)
        return board.get("phase")

    assert board.get("phase") == "starting"
    assert after(event(RunStarted, **STARTED)) == "running"
    prompt = PromptView(
        id=7, step="setup[0]", kind="confirm", text="Ready?", choices=("yes", "no"),
        expected="yes / no", unit="", picture="x.png",
    )  # fmt: skip
    assert after(Show({"prompt": prompt})) == "asking"
    assert board.get("prompt").picture == "/api/v1/pictures/x.png"
    assert board.get("prompt").choices == ("yes", "no")
    assert after(Show({"prompt": None})) == "running"
    assert board.get("prompt") is None
    story.request("pause")
    assert board.get("phase") == "pausing"
    assert after(Show({"pause": PAUSE})) == "paused"
    assert (board.get("asked"), board.get("pause").choices) == ("", ("resume", "abort"))
    assert after(Show({"pause": None})) == "running"
    assert after(event(Intervention, action="abort", by="interlock x")) == "ending"
    assert after(event(RunEnded, outcome=Outcome.ABORTED)) == "analysing"
    end = Finished(run="R1", folder="f", outcome="aborted", reason="", verdict="")
    assert after(Ended(end)) == "finished"
    assert board.get("finished") == end


def test_step_states_follow_the_run(board, story):
    states = []
    for message in (
        started(0), ended(0), started(1, "001"), ended(1, ok=False), started(1, "001"), ended(1),
        started(2, "002"), event(Intervention, action="skip", by="Ann"), started(3, "003"),
    ):  # fmt: skip
        story.take(message)
        states.append(board.get("progress").states)
    assert states == [
        "r...", "o...", "or..", "ox..", "or..", "oo..", "oor.", "oos.", "oosr",
    ]  # fmt: skip
    progress = board.get("progress")
    assert (progress.recording, progress.done_s, progress.left_s) == ("003", 30.0, 10.0)


def test_recording_of_statistics_only_is_shown_while_it_runs(board, story):
    wave = np.sin(np.arange(1000) / 30)
    story.take(event(RunStarted, **STARTED))
    story.take(started(1))
    block = Block(1000.0, 0, 0.0, {"tester.force": wave})
    story.take(event(Samples, recording="", block=block, monotonic_s=1.0))
    cycle = Curve(title="c", x=Axis("t"), y=Axis("F"), at=wave, series={"": wave}, end_s=1.0)
    story.take(Drawn("", cycle, 1.0))
    assert board.get("progress").recording == UNKEPT
    assert parse_frame(story.curves.next_curve())[0]["recording"] == UNKEPT
    assert story.curves.next_trend() is not None
    story.take(ended(1))
    assert board.get("progress").recording == ""


def test_step_interrupted_by_a_pause_is_pending_not_failed(board, story):
    for message in (started(0), ended(0), started(1, "001"), ended(1, ok=False)):
        story.take(message)
    assert board.get("progress").states == "ox.."
    story.take(Show({"pause": PAUSE}))
    assert board.get("progress").states == "o..."
    assert board.get("progress").left_s == 30.0
    story.take(started(1, "001"))
    assert board.get("progress").states == "or.."


SETTING = PlanView(
    estimated_s=30.0,
    steps=(step(0, "", **{"t.frequency": 5.0}), step(1, "", **{"t.load": 1000.0}), step(2, "")),
)
UNITS = {"t.frequency": "Hz", "t.load": "N", "t.temperature": "K"}


def read_back(index, **values):
    named = {f"t.{name}": value for name, value in values.items()}
    return ended(index, action="set", values=named, units=UNITS)


def test_set_points_and_readings_have_units(board, story):
    story.take(show_plan(SETTING))
    story.take(read_back(0, frequency=5.0))
    story.take(read_back(1, load=998.0))
    story.take(ended(2, values={"t.temperature": 296.15}, units=UNITS))
    readings = board.get("readings")
    assert (readings["t.frequency"].set, readings["t.load"].set) == (5.0, 1000.0)
    assert (readings["t.load"].value, readings["t.temperature"].unit) == (998.0, "K")
    assert readings["t.temperature"].shown == pytest.approx(23.0)
    assert readings["t.temperature"].set is None


def test_drive_shows_set_point_and_read_back_unless_its_set_failed(board, story):
    story.take(show_plan(SETTING))
    story.take(ended(1, values={"t.load": 0.4}, units=UNITS))
    story.take(read_back(1, load=998.0))
    load = board.get("readings")["t.load"]
    assert (load.set, load.value) == (1000.0, 998.0)
    failed = {"values": {"t.frequency": 3.0}, "units": UNITS}
    story.take(ended(0, ok=False, action="set", **failed))
    frequency = board.get("readings")["t.frequency"]
    assert (frequency.set, frequency.value) == (None, 3.0)


def test_set_point_is_in_the_unit_of_the_procedure(board, story):
    (drive,) = sets = {"c.temperature": 253.15}
    story.take(show_plan(PlanView(estimated_s=1.0, steps=(step(0, "", **sets),))))
    common = {"index": 0, "action": "set", "step": "main[0]"}
    story.take(event(StepStarted, **common, text="", written_in={drive: "°C"}))
    story.take(event(StepEnded, **common, ok=True, values={drive: 253.19}, units={drive: "K"}))
    reading = board.get("readings")[drive]
    assert (reading.set, reading.shown, reading.shown_in) == (-20.0, -19.96, "°C")


def test_drive_set_by_hand_shows_its_set_point(board, story):
    drive = {"long_name": "", "unit": "N", "minimum": 0.0, "maximum": 3000.0}
    drives = (DriveView(name="t.load", set=100.5, **drive),)
    story.take(ended(0, action="set", values={"t.load": 100.7}, units=UNITS))
    story.take(Show({"manual": ManualView(drives=drives, channels=(), recording="")}))
    reading = board.get("readings")["t.load"]
    assert (reading.set, reading.value) == (100.5, 100.7)


def test_drive_made_safe_shows_read_back_and_no_set_point(board, story):
    story.take(show_plan(SETTING))
    story.take(read_back(0, frequency=5.0))
    story.take(read_back(1, load=999.0))
    safe = {"t.load": 1.5, "t.frequency": 0.0}
    story.take(event(MadeSafe, what="t", read_back=safe))
    readings = board.get("readings")
    load = readings["t.load"]
    assert (load.set, load.value, load.utc) == (None, 1.5, "2026")
    assert (readings["t.frequency"].set, readings["t.frequency"].value) == (None, 0.0)
    assert readings["t.load"].unit == "N"


CHANNELS = (
    ChannelView(name="t.load", long_name="load", si="N", unit="N"),
    ChannelView(name="t.temperature", long_name="", si="K", unit="°C"),
)


def channels_of(board):
    return {channel.name: (channel.value, channel.utc) for channel in board.get("channels")}


def test_channel_shows_time_of_value_and_read_back_of_safe_state(board):
    story = Story(board, JobView(kind="run", procedure="p", station="s"), NoLinks())
    story.take(Show({"plan": PLAN, "channels": CHANNELS}))
    story.take(Values({"t.load": 999.0, "t.temperature": 293.15}, 1795435200.0, 0.5))
    channels = board.get("channels")
    assert [channel.interval_s for channel in channels] == [0.5, 0.5]
    assert channels_of(board)["t.temperature"] == (20.0, "2026-11-23T12:00:00.000Z")
    story.take(event(MadeSafe, what="t", read_back={"t.load": 0.4}, utc="2026-11-23T12:00:07.000Z"))
    assert channels_of(board) == {
        "t.load": (0.4, "2026-11-23T12:00:07.000Z"),
        "t.temperature": (20.0, "2026-11-23T12:00:00.000Z"),
    }
    assert board.get("readings")["t.load"].utc == "2026-11-23T12:00:07.000Z"
    story.take(ended(1, action="record", values={"t.load": 500.0}))  # a mean over the recording
    assert channels_of(board)["t.load"][0] == 0.4


def test_shown_sample_keeps_its_time(board):
    story = Story(board, JobView(kind="run", procedure="p", station="s"), NoLinks())
    story.take(Show({"plan": PLAN, "channels": CHANNELS}))
    block = Block(1000.0, 0, 0.0, {"t.load": np.array([1.0, 2.0], np.float32)})
    story.take(event(Samples, recording="1", block=block, utc="2020-01-01T00:00:00.000Z"))
    assert channels_of(board)["t.load"] == (2.0, "2020-01-01T00:00:00.000Z")


def test_samples_are_shown_when_system_clock_is_set_back(board, monkeypatch):
    story = Story(board, JobView(kind="run", procedure="p", station="s"), NoLinks())
    story.take(Show({"plan": PLAN, "channels": CHANNELS}))
    for value in (1.0, 2.0):
        monkeypatch.setattr("time.time", lambda hours=value: 1e9 - 3600.0 * hours)
        monkeypatch.setattr("time.monotonic", lambda seconds=value: seconds)
        block = Block(1000.0, 0, 0.0, {"t.load": np.array([value], np.float32)})
        story.take(event(Samples, recording="1", block=block))
    assert channels_of(board)["t.load"][0] == 2.0


def test_new_job_clears_the_earlier_one(board):
    story = Story(board, JobView(kind="run", procedure="p", station="s"), NoLinks())
    fresh = {name: board.get(name) for name in SECTIONS}
    story.take(Show({"plan": PLAN, "channels": CHANNELS}))
    story.take(event(RunStarted, **STARTED))
    story.take(started(1, "001"))
    story.take(ended(0, action="set", values={"t.load": 1.0}, units={"t.load": "N"}))
    story.take(Values({"t.load": 999.0}, 1795435200.0, 0.5))
    story.take(event(Alarm, source="x", text="hot"))
    story.take(Failed("it is so", "do this"))
    changed = {name for name in SECTIONS if board.get(name) != fresh[name]}
    assert changed == {
        "phase",
        "job",
        "plan",
        "progress",
        "channels",
        "readings",
        "alarms",
        "finished",
    }
    Story(board, JobView(kind="run", procedure="p", station="s"), NoLinks())
    assert {name: board.get(name) for name in SECTIONS} == fresh


def scan_started(index):
    fields = {"setpoints": {"t.frequency": 5.0}, "units": {"t.frequency": "Hz", "t.load": "N"}}
    return event(
        StepStarted, step=f"main[{index}]", index=index, action="scan", text="Scan", **fields
    )


def row(point, load):
    where = {"t.frequency": 5.0, "t.load": load}
    fields = {"setpoints": where, "values": {"t.load": load - 1, "t.temperature": 300.15}}
    return event(Scanned, step="main[1]", point=point, measurement="loads", **fields)


def test_scan_shows_its_points_and_progress(board):
    scan = step(1, "").model_copy(update={"scan_points": 4, "action": "scan"})
    story = Story(board, JobView(kind="run", procedure="p", station="s"), NoLinks())
    story.take(show_plan(PlanView(estimated_s=20.0, steps=(SETTING.steps[0], scan))))
    units = {"t.frequency": "Hz"}
    story.take(ended(0, action="set", values={"t.frequency": 5.0}, units=units))
    story.take(scan_started(1))
    events = board.events(-1)
    for point, load in enumerate((10.0, 20.0, 40.0)):
        story.take(row(point, load))
    readings, progress = board.get("readings"), board.get("progress")
    assert (readings["t.load"].set, readings["t.load"].value) == (40.0, 39.0)
    assert readings["t.temperature"].value == 300.15
    assert readings["t.load"].unit == "N"
    assert readings["t.frequency"].set == 5.0
    assert (progress.scanned, progress.scan_points) == (3, 4)
    assert (progress.done_s, progress.left_s) == (10.0 + 7.5, 2.5)
    assert board.events(-1) == events
    story.take(scan_started(1))  # once more: from its first point
    assert board.get("progress").scanned == 0
    story.take(ended(1, action="scan"))
    assert (board.get("progress").scanned, board.get("progress").scan_points) == (0, 0)
    assert board.get("progress").states == "oo"


def test_current_value_updates_reading_and_keeps_set_point(board, story):
    story.take(Show({"channels": CHANNELS, "plan": SETTING}))
    story.take(read_back(1, load=1000.0))
    story.take(Values({"t.load": 999.0, "t.temperature": 300.0}, 1795435200.0, 0.5))
    (name,) = board.get("readings")  # what no step has set or read is only among the channels
    now = board.get("readings")[name]
    assert (now.value, now.set, now.utc) == (999.0, 1000.0, "2026-11-23T12:00:00.000Z")


def test_new_job_has_no_readings_of_the_earlier_one(board, story):
    story.take(ended(0, action="set", values={"tester.load": 1000.0}, units={"tester.load": "N"}))
    Story(board, story.job, NoLinks())
    assert board.get("readings") == {}


def test_interlock_is_active_until_cleared_and_alarm_list_is_bounded(board, story):
    fields = {"interlock": "hot", "does": "pause", "latency_s": 0.1}
    story.take(event(InterlockTripped, source="interlock hot", text="too hot", **fields))
    assert [(alarm.text, alarm.active) for alarm in board.get("alarms")] == [("too hot", True)]
    story.take(event(InterlockCleared, step="interlock hot", text="fine", interlock="hot"))
    assert [alarm.active for alarm in board.get("alarms")] == [False]
    for number in range(300):
        story.take(event(Alarm, source="x", text=str(number)))
    assert len(board.get("alarms")) == 100
    assert board.get("alarms")[-1].text == "299"


def test_end_of_run_deactivates_interlocks(board, story):
    fields = {"interlock": "hot", "does": "pause", "latency_s": 0.1}
    story.take(event(InterlockTripped, source="interlock hot", text="too hot", **fields))
    story.take(event(Alarm, source="x", text="odd"))
    story.take(event(RunEnded, outcome=Outcome.COMPLETED))
    alarms = [(alarm.text, alarm.active, alarm.until_end) for alarm in board.get("alarms")]
    assert alarms == [("too hot", False, True), ("odd", False, False)]


LIVE = LiveView(recordings=1, final=False, problem="", taken_s=0.1)


def test_events_are_sent_and_cleared_by_the_next_job(board, story):
    story.take(event(RunStarted, **STARTED))
    story.take(event(StepEnded, step="a", index=0, action="read", ok=True, truth={"x": 1.0},
                     values={"t.load": nan}))  # fmt: skip
    events = json.loads(board.events(-1))
    assert [item["event"]["event"] for item in events["items"]] == ["RunStarted", "StepEnded"]
    assert events["items"][0]["event"]["run_id"] == "R1"
    assert events["items"][1]["event"]["values"] == {"t.load": None}
    assert events["items"][1]["event"]["truth"] == {}
    numbers = [item["number"] for item in events["items"]]
    messages = [json.loads(message) for message in board.new_events()]
    assert [message["number"] for message in messages] == numbers
    assert {message["type"] for message in messages} == {"event"}
    assert board.new_events() == []
    assert json.loads(board.events(numbers[0]))["items"] == events["items"][1:]
    Story(board, story.job, NoLinks())
    assert json.loads(board.events(-1)) == {"version": 1, "latest": numbers[-1], "items": []}


def test_late_interim_result_does_not_replace_final_result(board, story):
    story.take(event(RunStarted, **STARTED))
    story.take(Analysed(LIVE))
    assert board.get("live") == LIVE
    final = LIVE.model_copy(update={"final": True, "recordings": 4})
    end = Finished(run="R1", folder="f", outcome="completed", reason="", verdict="pass")
    story.take(Ended(end, final))
    story.take(Analysed(LIVE))  # an answer that came too late
    assert board.get("live") == final


def test_lost_process_is_reported_with_advice(board, story):
    for message in (event(RunStarted, **STARTED), started(0), ended(0), started(1, "001")):
        story.take(message)
    story.lost(-9)
    assert board.get("phase") == "finished"
    assert "code -9" in board.get("finished").reason
    assert "resume" in board.get("finished").hint
    assert board.get("progress").states == "ox.."
    story.lost(-9)  # once is enough
    assert board.get("phase") == "finished"


@pytest.mark.parametrize(("code", "outcome"), [("aborted", "aborted"), ("device", "error")])
def test_job_that_failed_to_start_shows_the_reason(board, story, code, outcome):
    story.take(Failed("it is so", "do this", code))
    finished = board.get("finished")
    assert board.get("phase") == "finished"
    assert (finished.outcome, finished.reason, finished.hint) == (outcome, "it is so", "do this")
    assert (finished.run, finished.sealed) == ("", False)


def test_preflight_allows_start_only_without_failures(board):
    story = Story(board, JobView(kind="preflight", procedure="p", station="s"), NoLinks())
    assert (board.get("phase"), board.get("preflight").done) == ("checking", False)
    good = PreflightItem(kind="disk", name="disk", state="warn", text="little")
    story.take(Show({"preflight": Preflight.of(story.job, (good,))}))
    assert board.get("preflight").items == (good,)
    story.take(Ended())
    assert (board.get("phase"), board.get("preflight").may_start) == ("idle", True)
    story = Story(board, JobView(kind="preflight", procedure="p", station="s"), NoLinks())
    story.take(Failed("no such file", "look", "invalid"))
    preflight = board.get("preflight")
    assert (preflight.done, preflight.may_start, preflight.items[0].state) == (True, False, "fail")
    assert preflight.items[0].fix == "look"


def test_interim_findings_of_analyses_are_shown(board, story):
    of = ResultDefinition(name="voltage", text="output voltage", unit="V")
    now = MeasurementResult(of=of, estimate=Estimate(5.0, nan, nan, "V"), readings=300)
    story.take(LiveFindings(Findings(results=(now,))))
    (row,) = board.get("live").results
    assert (row.name, row.value, row.U, row.readings) == ("voltage", 5.0, None, 300)
