"""The queue over HTTP: what is added, what is refused, and that Stop waits for nothing."""

from __future__ import annotations

import threading
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from filelock import FileLock
from starlette.testclient import TestClient

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner_panel.sequence import PendingStart
from rigrunner_panel.view.sections import AlarmView, Finished
from rigrunner_panel.web import queueing
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.panel import Panel, Settings

ANN = {"X-Rigrunner-Client": "client-ann"}
PROGRAM = {"X-Rigrunner-Client": "client-lims"}
PAIR = {"procedure": "starting_torque_1000n", "station": "simulated"}


@pytest.fixture
def panel(tmp_path):
    (tmp_path / "lab").mkdir()
    return Panel(settings=Settings(runs=tmp_path / "runs", procedures=tmp_path / "lab"))


@pytest.fixture
def client(panel):
    panel.rig("simulated")
    app = make_app(panel)
    with TestClient(app, base_url="http://127.0.0.1:8750", headers=ANN) as client:
        assert client.post("/api/v1/control", json={"name": "Ann"}).status_code == 200
        yield client


def post(client, path, status=200, headers=ANN, **body):
    answer = client.post(f"/api/v1/queue/{path}", json=body, headers=headers)
    assert answer.status_code == status, answer.text
    return answer.json()


def entries(client):
    items = client.get("/api/v1/queue").json()["entries"]
    return [(entry["specimen"], entry["status"]) for entry in items]


def test_list_is_added_moved_held_released_and_skipped(client):
    assert post(client, "add", **PAIR, list="SN-1\nSN-2\nSN-3\n") == {"entries": [1, 2, 3]}
    post(client, "move", entry=3, before=1)
    post(client, "hold", entry=1, reason="dirty")
    post(client, "skip", entry=2, reason="lost")
    assert entries(client) == [("SN-3", "waiting"), ("SN-1", "held"), ("SN-2", "skipped")]
    post(client, "release", entry=1)
    post(client, "repeat", entry=2, reason="found")
    state = client.get("/api/v1/state").json()["queue"]
    assert [entry["status"] for entry in state["entries"]] == [
        "waiting", "waiting", "skipped", "waiting",
    ]  # fmt: skip
    assert (state["next"], state["entries"][3]["repeats"]) == (3, 2)
    assert post(client, "clear") == {"removed": 1}


def test_proposed_entry_waits_for_a_person(client):
    post(client, "propose", **PAIR, list="SN-1", by="LIMS", headers=PROGRAM)
    assert entries(client) == [("SN-1", "proposed")]
    assert client.get("/api/v1/queue").json()["entries"][0]["by"] == "LIMS"
    assert "is not waiting" in post(client, "start", status=409, entry=1)["message"]
    assert "no entry" in post(client, "start", status=409)["message"]
    refused = post(client, "release", status=403, entry=1, headers=PROGRAM)
    assert refused["code"] == "not_in_control"
    assert entries(client) == [("SN-1", "proposed")]


def test_program_must_name_itself_and_person_in_control_is_named(client):
    refused = post(client, "propose", status=422, **PAIR, list="SN-1", headers=PROGRAM)
    assert refused["message"] == "a proposal needs a name"
    post(client, "propose", **PAIR, list="SN-2")
    assert [entry["by"] for entry in client.get("/api/v1/queue").json()["entries"]] == ["Ann"]


def test_proposed_entry_starts_only_after_release_at_its_rig(client, panel):
    panel.rig("simulated_bench")
    ours, theirs = {"rig": "simulated"}, {"rig": "simulated_bench"}
    client.post("/api/v1/control", json={"name": "Lims"}, params=theirs, headers=PROGRAM)
    body = {**PAIR, "list": "SN-1", "by": "LIMS"}
    client.post("/api/v1/queue/propose", json=body, params=ours, headers=PROGRAM)
    refused = client.post(
        "/api/v1/queue/release", json={"entry": 1}, params=theirs, headers=PROGRAM
    )
    assert "is in the queue of simulated, not of simulated_bench" in refused.json()["message"]
    start = {**PAIR, "inputs": {"specimen": "SN-1"}, "entry": 1}
    refused = client.post("/api/v1/run/start", json=start, params=theirs, headers=PROGRAM)
    assert refused.status_code == 400
    refused = client.post("/api/v1/run/start", json=start, params=ours)
    assert "entry 1 is proposed, expected waiting" in refused.json()["message"]
    (entry,) = client.get("/api/v1/queue", params=ours).json()["entries"]
    assert entry["status"] == "proposed"


@pytest.mark.parametrize("run", ["../lab", "/etc", "..", ".", "no such run"])
def test_partner_run_must_be_in_the_folder_of_runs(client, run):
    body = {**PAIR, "list": "SN-1", "partners": {"no_load": run}}
    assert post(client, "add", status=404, **body)["code"] == "not_found"
    assert (
        post(client, "propose", status=404, **body, by="LIMS", headers=PROGRAM)["code"]
        == "not_found"
    )
    assert entries(client) == []


def test_all_invalid_lines_of_a_list_are_reported(client):
    post(client, "add", **PAIR, list="SN-1")
    refused = post(client, "add", status=422, **PAIR, list="sn-1\na\x00b\nSN-2")
    assert [problem["where"] for problem in refused["problems"]] == ["list:2", ""]
    post(client, "add", status=422, **PAIR, list="a\x00b")
    assert entries(client) == [("SN-1", "waiting")]


def test_duplicate_specimen_is_refused_with_its_entry(client):
    post(client, "add", **PAIR, list="SN-1")
    refused = post(client, "add", status=422, **PAIR, list="SN-0\nsn-1")
    (problem,) = refused["problems"]
    assert problem["message"] == "SN-1 is already in the queue: entry 1, waiting"
    assert entries(client) == [("SN-1", "waiting")]


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({**PAIR, "list": "x" * 60_001}, 400),
        ({**PAIR, "list": "x\n" * 1001}, 422),
        ({**PAIR, "list": "specimen,typ\nSN-1,GE"}, 422),
        ({**PAIR, "list": "SN\u202e1"}, 422),
        ({**PAIR, "list": "a\x00b"}, 422),
        ({**PAIR, "inputs": {"nobody asks": "x"}}, 422),
        ({**PAIR, "inputs": {"specimen": " "}}, 422),
        ({**PAIR, "procedure": "../../etc/passwd"}, 404),
        ({**PAIR, "station": "/etc/passwd"}, 404),
        ({**PAIR, "state": "started"}, 400),
        ({**PAIR, "list": "SN-1", "by": "Ann\u202e"}, 400),
    ],
)
@pytest.mark.parametrize("path", ["add", "propose"])
def test_hostile_lists_are_refused_and_leave_nothing(client, path, body, status):
    post(client, path, status=status, **body)
    assert entries(client) == []


def test_oversized_body_is_refused(client):
    body = b'{"list": "' + b"x" * 70_000 + b'"}'
    headers = {**ANN, "Content-Type": "application/json"}
    assert client.post("/api/v1/queue/add", content=body, headers=headers).status_code == 413


@pytest.mark.parametrize("origin", ["http://evil.example", "null"])
def test_another_site_cannot_propose(client, origin):
    answer = client.post("/api/v1/queue/propose", json=PAIR, headers={**PROGRAM, "Origin": origin})
    assert (answer.status_code, answer.json()["code"]) == (403, "foreign_origin")
    form = {**PROGRAM, "Content-Type": "text/plain"}
    assert client.post("/api/v1/queue/propose", content=b"{}", headers=form).status_code == 400
    assert entries(client) == []


def test_stop_does_not_wait_for_the_queue_or_its_lock(client, panel):
    """Requests wait for a file that another program has locked; Stop is answered nevertheless."""
    panel.settings.runs.mkdir()
    proposal = {**PAIR, "by": "LIMS"}
    with FileLock(panel.settings.runs / ".queue.lock"), panel.rig("simulated").sequence.lock:
        threads = [
            threading.Thread(
                target=client.post, args=("/api/v1/queue/propose",), kwargs={"json": proposal}
            )
            for _ in range(45)
        ]
        for thread in threads:
            thread.start()
        time.sleep(0.5)
        assert client.post("/api/v1/stop", json={}).json() == {"ok": True, "stopped": False}
        assert all(thread.is_alive() for thread in threads), "Stop waited for one of them"
    for thread in threads:
        thread.join()


def test_stop_cancels_automatic_starts(client, panel):
    post(client, "automatic", on=True)
    assert client.get("/api/v1/queue").json()["automatic_by"] == "Ann"
    client.post("/api/v1/stop", json={})
    assert client.get("/api/v1/queue").json()["automatic_by"] == ""
    queueing.tick(panel.rig("simulated"))
    assert panel.rig("simulated").sequence.pending is None


def test_start_cancelled_by_stop_is_shown_on_every_screen(client, panel):
    rig = panel.rig("simulated")
    post(client, "add", **PAIR, list="SN-1")
    post(client, "automatic", on=True)
    rig.sequence.pending = PendingStart(1, "Ann", rig.sequence.stops)
    queueing.refresh(rig)
    client.post("/api/v1/stop", json={})
    queueing.tick(rig)
    shown = rig.board.get("queue")  # a request for the queue would refresh it
    assert (shown.automatic_by, shown.starting) == ("", None)


@pytest.mark.parametrize("field", ["active", "until_end"])
def test_uncleared_interlock_prevents_automatic_start(client, panel, field):
    post(client, "add", **PAIR, list="SN-1")
    post(client, "automatic", on=True)
    rig = panel.rig("simulated")
    alarm = {"seq": 1, "utc": "2026", "source": "interlock hot", "text": "hot", "active": False}
    rig.board.put(alarms=(AlarmView(**{**alarm, field: True}),))
    queueing.tick(rig)
    state = client.get("/api/v1/queue").json()
    assert (state["problem"], state["automatic_by"]) == ("an alarm is active", "")


@pytest.mark.parametrize(
    ("switched_on", "alarm", "by_itself", "problem", "starts"),
    [
        (True, True, True, "an alarm is active", False),
        (False, False, True, "", False),
        (True, False, True, "", True),
        (False, True, False, "", True),  # a person asked for it, and sees the alarm
    ],
)
def test_automatic_start_respects_changes_during_its_preflight(  # noqa: PLR0917
    client, panel, monkeypatch, switched_on, alarm, by_itself, problem, starts
):
    post(client, "add", **PAIR, list="SN-1")
    rig, started = panel.rig("simulated"), []
    monkeypatch.setattr(queueing, "preflight_passed", lambda *_: True)
    monkeypatch.setattr(queueing, "_claim_and_start", lambda _, entry, *__: started.append(entry))
    rig.sequence.pending = PendingStart(1, "Ann", rig.sequence.stops, by_itself)
    rig.sequence.automatic_by = "Ann" if switched_on else ""
    fields = {"seq": 1, "utc": "2026", "source": "rig", "text": "energised", "active": alarm}
    rig.board.put(alarms=(AlarmView(**fields),))
    with rig.sequence.lock:
        queueing._after_preflight(rig)
    assert (client.get("/api/v1/queue").json()["problem"], len(started)) == (problem, int(starts))


def test_unknown_state_of_the_rigs_is_an_alarm(panel, monkeypatch):
    """An exception here would end the updates of all screens."""

    def fail(_path):
        raise OSError(5, "Input/output error")

    rig = panel.rig("simulated")
    with monkeypatch.context() as broken:
        broken.setattr(Path, "is_dir", fail)
        rig.desk.tick()
    (alarm,) = rig.board.get("alarms")
    assert alarm.active
    assert "is not a folder for locks: Input/output error" in alarm.text


@pytest.mark.parametrize("error", [InvalidFileError([Problem("a bad step")]), OSError(5, "broken")])
def test_entry_whose_job_could_not_be_started_is_held(client, panel, monkeypatch, error):
    """Nothing has moved: nobody has to decide how to go on with an interrupted run."""
    post(client, "add", **PAIR, list="SN-1")
    rig = panel.rig("simulated")

    def fail(*_, **__):
        raise error

    monkeypatch.setattr(queueing, "start_job", fail)
    entry = rig.queue.get(1)
    with pytest.raises(type(error)):
        queueing._claim_and_start(rig, entry, "Ann", queueing._body(entry))
    ((_, status),) = entries(client)
    assert status == "held"
    assert str(error) in rig.queue.get(1).reason


def test_entry_whose_run_could_not_be_noted_is_not_offered_again(client, panel):
    """The queue's file failed as the run began: a second test of the specimen cannot be undone."""
    post(client, "add", **PAIR, list="SN-1")
    rig = panel.rig("simulated")
    with ExitStack() as claim:
        claim.enter_context(rig.queue.started(1, "Ann"))
        rig.sequence.entry, rig.sequence.entry_lock = 1, claim.pop_all()
    fields = {"run": "2026_WEAR", "folder": "", "outcome": "error", "reason": "broken"}
    rig.board.put(finished=Finished(**fields, verdict=""))
    queueing.tick(rig)
    assert rig.queue.get(1).run == "2026_WEAR"
    assert entries(client) == [("SN-1", "interrupted")]  # there is no such folder here


def test_queue_goes_on_after_the_file_with_its_running_entry_was_moved(client, panel):
    post(client, "add", **PAIR, list="SN-1")
    rig = panel.rig("simulated")
    with ExitStack() as claim:
        claim.enter_context(rig.queue.started(1, "Ann"))
        rig.sequence.entry, rig.sequence.entry_lock = 1, claim.pop_all()
    file = rig.queue.path("simulated")
    file.rename(file.with_suffix(".old"))
    queueing.tick(rig)
    assert "the queue has no entry 1" in rig.board.get("queue").problem
    post(client, "add", **PAIR, list="SN-2")
    queueing.tick(rig)
    with rig.queue.started(1, "Ann") as entry:
        assert entry.specimen == "SN-2"


def test_unreadable_queue_is_reported_and_not_changed(client, panel):
    panel.settings.runs.mkdir()
    panel.rig("simulated").queue.path("simulated").write_text("{}x", encoding="utf-8")
    assert "queue-simulated.json" in client.get("/api/v1/queue").json()["problem"]
    assert post(client, "add", status=422, **PAIR, list="SN-1")["code"] == "data"
    assert panel.rig("simulated").queue.path("simulated").read_text(encoding="utf-8") == "{}x"
    assert client.post("/api/v1/stop", json={}).status_code == 200
