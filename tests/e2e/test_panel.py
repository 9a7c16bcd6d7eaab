"""The panel, served and driven over HTTP and WebSocket, with a run in its own process."""

from __future__ import annotations

import os
import signal
import socket
import time
from contextlib import contextmanager
from datetime import datetime
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from e2e.helpers_panel import INPUTS, Screen, process_is_gone, ready, rig_process, served
from e2e.helpers_terminal import Terminal
from helpers_cli import call
from helpers_thorough import first
from helpers_workflow import edited, quick_procedure, run, station_file
from rigrunner.api.errors import ExitCode
from rigrunner.api.events import Intervention, MadeSafe, RunEnded
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import read

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals as POSIX has them")

QUICK = "{seed: 1, frequency_rate: 100 Hz/s, load_rate: 10 kN/s}"
LOADED = "starting_torque_1000n.yaml"
ENDLESS = "endless.yaml"
"""The same with points of a minute, so that a test has time to act during a run."""
STOP_S = 0.2
"""The panel's limit from the request to the command that makes the rig safe."""


RIG = "station.yaml"
"""Tests write other stations beside it; each is a rig of the panel."""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Return a lab folder with short procedures, and a no-load run in 'runs'."""
    folder = tmp_path_factory.mktemp("lab")
    short = ("settle: {cycles: 100}", "settle: {cycles: 5}")
    no_load = quick_procedure(folder, "no_load_inertia_sweep")
    loaded = quick_procedure(folder, "starting_torque_1000n", short)
    edited(loaded, folder / ENDLESS, long=("cycles: 12}", "cycles: 900}"))
    station = station_file(folder, ("{seed: 1}", QUICK))
    run(no_load, folder / "runs", station=station, clock=SimulatedClock())
    return folder


@pytest.fixture(scope="module")
def server(lab):
    with served(lab, lab / "runs") as server:
        yield server


@pytest.fixture
def screen(server):
    with screen_of(server, RIG) as screen:
        yield screen


@contextmanager
def screen_of(server, rig):
    screen = Screen(server, "client-ann-0001", rig)
    yield screen
    if not screen.is_closed and screen.state["phase"] not in ("idle", "finished"):
        screen.post("stop")
        screen.phase("finished", "idle")
    screen.close()


def start(screen, *, realtime=True, **more):
    pair = ready(screen, ENDLESS if realtime else LOADED)
    screen.post("run/start", 202, **pair, inputs=INPUTS, realtime=realtime, operator="Ann", **more)


def stored(lab, state):
    return read(lab / "runs" / state["finished"]["run"])


def events_of(run, kind):
    return [event for event in run.events if isinstance(event, kind)]


@pytest.mark.parametrize("delay_s", first(1, [0.0, 0.3, 1.0]))
def test_stop_while_the_process_starts_ends_it_in_order(screen, server, delay_s):
    start(screen)
    time.sleep(delay_s)
    screen.post("stop")
    finished = screen.phase("finished")["finished"]
    assert finished["outcome"] == "aborted"
    assert finished["reason"].startswith("stopped at the panel")
    assert "resume" not in finished["hint"]
    assert "Fatal Python error" not in "".join(server.output)


@pytest.mark.thorough
def test_complete_run_with_a_watcher_and_a_reload(screen, server):
    watcher = Screen(server, "client-bob-0001", RIG)
    hostile = "<script>alert(1)</script>/../x"
    pair = ready(screen, LOADED)
    items = screen.state["preflight"]["items"]
    kinds = ["procedure", "partner", "calibration", "disk", "device", "interlock", "zero"]
    assert [item["kind"] for item in items] == kinds
    refused = watcher.post("run/start", 403, **pair)
    assert refused["message"] == "Ann has control"
    inputs = {"specimen": hostile, "type": "GE20", "lot": "L-7", "operator": "Ann"}
    screen.post("run/start", 202, **pair, inputs=inputs, realtime=False)
    second = screen.post("run/start", 202, **pair, inputs=inputs)  # it waits in the queue
    screen.post("queue/skip", entry=second["entry"], reason="a test")
    prompt = screen.phase("asking")["prompt"]
    assert (prompt["kind"], prompt["choices"]) == ("confirm", ["yes", "no"])
    wrong = screen.post("run/answer", 422, prompt=prompt["id"], text="perhaps")
    assert "expected one of: yes, no" in wrong["message"]
    screen.close()  # the browser is closed during the run
    again = Screen(server, "client-ann-0001", RIG)
    assert again.state["prompt"] == prompt
    again.answer()
    state = again.phase("finished")
    assert (state["finished"]["outcome"], state["finished"]["verdict"]) == ("completed", "pass")
    assert set(state["progress"]["states"]) == {"o"}
    result = again.http.get(f"/api/v1/runs/{state['finished']['run']}").json()
    assert result["item"]["specimen"] == hostile
    headline = result["result"]["headline"]["compensated"]
    live = state["live"]
    assert (live["final"], live["headline"]["value"]) == (True, headline["value"])
    assert live["headline"]["U"] == headline["expanded_uncertainty_95"]
    assert len(live["results"]) == 5
    watcher.phase("finished")
    events = watcher.http.get("/api/v1/events").json()["items"]
    assert events == [
        {key: event[key] for key in ("number", "text", "event")} for event in watcher.events
    ]
    assert [events[0]["event"]["event"], events[-1]["event"]["event"]] == ["RunStarted", "RunEnded"]
    later = watcher.http.get("/api/v1/events", params={"after": events[-2]["number"]}).json()
    assert later["items"] == events[-1:]
    assert watcher.http.get("/api/v1/events", params={"after": "x"}).status_code == 400
    shared = ("phase", "live", "finished", "progress", "readings", "plan")
    assert {key: watcher.state[key] for key in shared} == {key: state[key] for key in shared}
    names = {file["name"] for file in state["finished"]["files"]}
    assert {"report.html", "result.json", "run.h5"} <= names
    assert {header["kind"] for header, _ in watcher.frames} == {"curve", "trend"}
    watcher.close()
    again.close()


def actions(screen):
    """Return the actions of people among the events."""
    return [event["event"].get("action") for event in screen.events]


def test_pause_repeat_skip_take_over_and_abort_are_recorded(screen, server, lab):
    start(screen)
    screen.answer()
    screen.until(lambda state: state["progress"]["recording"])
    screen.post("run/pause")
    pause = screen.phase("paused")["pause"]
    assert set(pause["choices"]) >= {"resume", "repeat", "skip", "abort"}
    screen.post("run/note", text="looks good")
    screen.post("run/override", 409, reason="no")
    screen.post("run/resume")
    screen.post("run/resume", 409)
    screen.until(lambda state: state["progress"]["recording"])
    screen.post("run/repeat", reason="once more")  # pauses by itself
    screen.until(lambda _: "repeat" in actions(screen))
    screen.until(lambda state: state["progress"]["recording"])
    bob = Screen(server, "client-bob-0001", RIG)
    bob.post("run/skip", 403, reason="mine")
    bob.post("control", 409, name="Bob")
    bob.post("control", name="Bob", take_over=True)
    screen.post("run/abort", 403, reason="mine")
    screen.until(lambda _: "take over" in actions(screen))
    bob.post("run/skip", 400, reason=" ")
    bob.post("run/skip", reason="cracked")
    screen.until(lambda state: "s" in state["progress"]["states"])
    bob.post("run/abort", reason="enough")
    state = screen.phase("finished")
    assert state["finished"]["outcome"] == "aborted"
    run = stored(lab, state)
    interventions = events_of(run, Intervention)
    assert [(event.action, event.by) for event in interventions] == [
        ("pause", "Ann"), ("resume", "Ann"), ("pause", "Ann"), ("repeat", "Ann"),
        ("take over", "Bob"), ("pause", "Bob"), ("skip", "Bob"), ("abort", "Bob"),
    ]  # fmt: skip
    take_over = next(event for event in interventions if event.action == "take over")
    assert take_over.subject == "control was with Ann"
    assert any("enough" in event.reason for event in interventions)
    (ended,) = events_of(run, RunEnded)
    assert set(ended.read_back.values()) == {0.0}
    bob.close()


def test_stop_by_anyone_makes_the_rig_safe_in_time(screen, server, lab):
    start(screen)
    screen.answer()
    screen.until(lambda state: state["progress"]["recording"])
    frames = len(screen.frames)
    screen.until(lambda _: len(screen.frames) > frames + 3)
    bob = Screen(server, "client-bob-0001", RIG)
    requested_s = time.time()
    assert bob.post("stop", reason="smoke")["stopped"]
    state = screen.phase("finished")
    run = stored(lab, state)
    assert run.info.sealed
    (stop,) = [event for event in events_of(run, Intervention) if event.action == "abort"]
    delay_s = datetime.fromisoformat(stop.utc).timestamp() - requested_s
    assert delay_s < 10 * STOP_S  # on a busy machine
    assert "smoke" in stop.reason
    assert "panel client" in stop.by
    safe = [event.what for event in events_of(run, MadeSafe)]
    assert safe == ["tester.frequency", "tester.load", "tester"]
    assert not any("teardown" in getattr(event, "step", "") for event in run.events)
    assert not bob.post("stop")["stopped"]
    bob.close()


@pytest.mark.thorough
def test_run_continues_without_clients_and_with_a_stalled_one(screen, server):
    start(screen)
    screen.answer()
    host, port = server.address.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port))) as stalled:
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        stalled.sendall(
            f"GET /api/v1/events?client=client-stalled-1 HTTP/1.1\r\nHost: {host}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
        )
        before = screen.until(lambda state: state["watchers"] == 2)["progress"]["done_s"]
        screen.close()
        time.sleep(1.5)
        again = Screen(server, "client-ann-0001", RIG)
        assert again.state["phase"] == "running"
        again.until(lambda state: state["progress"]["done_s"] > before)
        again.post("run/abort", reason="seen enough")
        again.phase("finished")
        again.close()


def test_killed_run_process_is_reported_and_next_run_starts(screen, server):
    start(screen)
    screen.phase("asking")
    os.kill(rig_process(server), signal.SIGKILL)
    state = screen.phase("finished")
    assert "code -9" in state["finished"]["reason"]
    assert "resume" in state["finished"]["hint"]
    start(screen, realtime=False)
    screen.phase("asking")


@pytest.mark.thorough
def test_manual_point_is_recorded_apart_from_procedures(screen, lab):
    pair = ready(screen, LOADED)
    screen.post("manual/set", 409, drive="tester.load", value="1000 N")
    screen.post("manual/open", 202, **pair, operator="Ann")
    screen.until(lambda state: state["manual"])
    beyond = screen.post("manual/set", 422, drive="tester.frequency", value="99 Hz")
    assert "out of range (0 to 35 Hz)" in beyond["message"]
    screen.post("manual/set", 422, drive="tester.frequency", value="10")
    screen.post("manual/set", 404, drive="tester.speed", value="10 Hz")
    screen.post("manual/record", cycles=8)
    screen.until(lambda state: "is at rest" in state["manual"]["refused"])
    screen.post("manual/set", drive="tester.load", value="1 kN")
    screen.post("manual/set", drive="tester.frequency", value="20 Hz")
    watched = screen.until(lambda state: state["live"] and state["live"]["results"])["live"]
    (row,) = watched["results"]
    assert (row["place"], row["is_ongoing"]) == ("20 Hz", True)
    assert row["value"] == pytest.approx(0.726, abs=0.02)
    screen.post("manual/record", cycles=12)
    screen.until(lambda state: any(not row["is_ongoing"] for row in state["live"]["results"]))
    screen.post("manual/close")
    state = screen.phase("finished")
    (row,) = state["live"]["results"]
    assert row["readings"] == 12
    assert row["value"] == pytest.approx(0.726, abs=0.02)
    run = stored(lab, state)
    assert run.header.procedure_id == "SSPB-STT-1000-by-hand"
    assert run.header.approval["state"] == "draft"
    assert [recording.name for recording in run.recordings] == ["001_20Hz"]
    assert set(run.zeros) == {"tester.torque"}
    (ended,) = events_of(run, RunEnded)
    assert set(ended.read_back.values()) == {0.0}


@pytest.mark.thorough
def test_failed_preflight_starts_only_with_name_and_reason(server, lab):
    text = (lab / "station.yaml").read_text(encoding="utf-8")
    overdue = "certificate: C-1\n    laboratory: L\n    calibrated: 2020-01-01\n    due: 2021-01-01"
    assert "calibration: simulated" in text
    changed = text.replace("calibration: simulated", overdue)
    (lab / "overdue.yaml").write_text(changed, encoding="utf-8")
    with screen_of(server, "overdue.yaml") as screen:
        assert_start_needs_name_and_reason(screen, lab)


def assert_start_needs_name_and_reason(screen, lab):
    pair = ready(screen, "no_load_inertia_sweep.yaml", "overdue.yaml")
    preflight = screen.state["preflight"]
    (failed,) = [item for item in preflight["items"] if item["state"] == "fail"]
    assert (failed["kind"], failed["override"], preflight["may_start"]) == (
        "calibration", "tester.torque", False,
    )  # fmt: skip
    assert "was due on 2021-01-01" in failed["text"]
    inputs = {"operator": "Ann"}
    assert "was due" in screen.post("run/start", 409, **pair, inputs={})["message"]
    nameless = {"what": ["tester.torque"], "by": " ", "reason": "r"}
    screen.post("run/start", 400, **pair, override=nameless)
    wrong = {"what": ["everything"], "by": "Chief", "reason": "r"}
    screen.post("run/start", 422, **pair, override=wrong)
    override = {"what": ["tester.torque"], "by": "Chief", "reason": "new one ordered"}
    screen.post("run/start", 202, **pair, inputs=inputs, override=override)
    screen.until(lambda _: any("new one ordered" in event["text"] for event in screen.events))
    screen.post("stop")
    run = stored(lab, screen.phase("finished"))
    (event,) = [event for event in events_of(run, Intervention) if event.action == "override"]
    assert (event.by, event.reason) == ("Chief", "new one ordered")


def test_station_with_silent_device_cannot_be_started(server, lab):
    text = (lab / "station.yaml").read_text(encoding="utf-8")
    unplugged = text.replace(QUICK, "{seed: 1, simulate: unplugged}")
    (lab / "unplugged.yaml").write_text(unplugged, encoding="utf-8")
    with screen_of(server, "unplugged.yaml") as screen:
        pair = ready(screen, "no_load_inertia_sweep.yaml", "unplugged.yaml")
        items = screen.state["preflight"]["items"]
        (failed,) = [item for item in items if item["state"] == "fail"]
        assert (failed["kind"], failed["name"], failed["override"]) == ("device", "tester", "")
        assert failed["fix"]
        screen.post("run/start", 409, **pair)


@pytest.mark.thorough
def test_ctrl_c_ends_the_panel_once_its_run_is_safe_and_sealed(lab):
    with served(lab, lab / "runs") as server:
        screen = Screen(server, "client-ann-0001", RIG)
        start(screen)
        screen.answer()
        name = screen.until(lambda state: state["progress"]["recording"])["job"]["run"]
        code, output = server.end(signal.SIGINT)
        screen.close()
    assert code == 130
    assert f"{name} is running. Aborting: teardown" in output
    run = read(lab / "runs" / name)
    assert (run.info.sealed, run.info.outcome) == (True, "aborted")
    assert any("teardown" in getattr(event, "step", "") for event in run.events)


@pytest.mark.thorough
def test_closed_terminal_ends_the_panel_once_its_run_is_safe_and_sealed(lab):
    runs = lab / "runs"
    words = ("panel", "--port", "0", "--no-browser", "--procedures", str(lab), "--runs", str(runs))
    with Terminal(words, str(lab)) as terminal:
        terminal.wait_for("Panel: ")
        terminal.wait_for("\n")
        screen = Screen(
            SimpleNamespace(address=terminal.passed.strip().rstrip("/")), "client-ann-0001", RIG
        )
        start(screen)
        screen.answer()
        name = screen.until(lambda state: state["progress"]["recording"])["job"]["run"]
        terminal.hang_up()
        terminal.process.send_signal(signal.SIGHUP)  # as a shell does, too
        assert terminal.ends_with() == 130
        screen.close()
    run = read(runs / name)
    assert (run.info.sealed, run.info.outcome) == (True, "aborted")
    assert "SIGHUP to the panel" in run.info.reason
    assert any("teardown" in getattr(event, "step", "") for event in run.events)
    (ended,) = events_of(run, RunEnded)
    assert ended.read_back == {"tester.frequency": 0.0, "tester.load": 0.0}


def test_ctrl_c_without_a_run_ends_the_panel(lab):
    with served(lab, lab / "runs") as server:
        assert server.end(signal.SIGINT) == (0, "")


@pytest.mark.thorough
def test_run_ends_in_order_when_the_panel_is_killed(lab):
    with served(lab, lab / "runs") as server:
        screen = Screen(server, "client-ann-0001", RIG)
        start(screen)
        screen.answer()
        name = screen.until(lambda state: state["progress"]["recording"])["job"]["run"]
        pid = rig_process(server)
        server.process.kill()
        screen.close()
    assert process_is_gone(pid)
    run = read(lab / "runs" / name)
    assert (run.info.sealed, run.info.outcome) == (True, "aborted")
    assert "the panel is gone" in run.info.reason


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--host", "0.0.0.0"], "there is no token"),  # noqa: S104  (refused before it listens)
        (["--token", "short"], "fewer than 16 characters"),
        (["--port", "70000"], "70000"),
        (["--procedures", "/nowhere-at-all"], "/nowhere-at-all"),
    ],
)
def test_invalid_option_is_refused_with_the_reason(tmp_path, monkeypatch, options, message):
    serve = Mock(side_effect=AssertionError("it was opened"))
    monkeypatch.setattr("rigrunner_panel.serve._serve_until_end", serve)
    common = ("--no-browser", "--procedures", tmp_path, "--runs", tmp_path / "runs")
    refused = call("panel", "--port", "0", *common, *options)
    assert (refused.code, message in refused.err) == (ExitCode.USAGE, True), refused.err
