"""Procedures as text at the panel: opened, checked, compared, saved, approved and refused."""

from __future__ import annotations

import hashlib
import os
import threading
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from helpers_cli import call
from rigrunner.api.errors import InvalidFileError
from rigrunner.run.approval import approval_file
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.planning import planned_run
from rigrunner.yamlfile.reader import MAX_BYTES
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.panel import Panel, Settings

ANN = {"X-Rigrunner-Client": "client-ann"}
BOB = {"X-Rigrunner-Client": "client-bob"}
NAME = "procedures/sweep.yaml"
SHIPPED = "no_load_inertia_sweep"
TEXT = find_procedure(SHIPPED).read_text(encoding="utf-8")
WRONG = TEXT.replace("title:", "titel:", 1)


@pytest.fixture
def lab(tmp_path):
    folder = tmp_path / "lab"
    (folder / "procedures").mkdir(parents=True)
    (folder / NAME).write_text(TEXT, encoding="utf-8")
    return folder


@pytest.fixture
def panel(lab):
    return Panel(settings=Settings(runs=lab / "runs", procedures=lab))


@pytest.fixture
def client(panel):
    panel.rig("simulated")
    app = make_app(panel)
    with TestClient(app, base_url="http://127.0.0.1:8750", headers=ANN) as client:
        yield client


def open_text(client, name=NAME):
    return client.get("/api/v1/procedures/text", params={"name": name})


def post(client, what, **body):
    return client.post(f"/api/v1/procedures/{what}", json={"procedure": NAME, **body})


def save(client, text, digest, author="Ann", **more):
    return post(client, "save", text=text, digest=digest, by=author, **more)


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_text_has_the_digest_of_its_file(client, lab):
    procedure = open_text(client).json()
    assert (procedure["text"], procedure["digest"]) == (TEXT, sha256(lab / NAME))
    assert (procedure["shipped"], procedure["changed_by"]) == (False, "")
    assert procedure["state"] == "draft"
    assert open_text(client, SHIPPED).json()["shipped"]


def test_save_writes_the_file_and_records_its_author(client, lab):
    (lab / NAME).chmod(0o640)
    changed = TEXT + "# ü\n"
    answer = save(client, changed, open_text(client).json()["digest"])
    assert (lab / NAME).read_text(encoding="utf-8") == changed
    assert answer.json()["digest"] == sha256(lab / NAME)
    assert (lab / NAME).stat().st_mode & 0o777 == 0o640
    assert open_text(client).json()["changed_by"] == "Ann"
    assert [path.name for path in (lab / "procedures").iterdir()] == ["sweep.yaml"]


def test_file_changed_meanwhile_is_not_overwritten(client, lab):
    digest = open_text(client).json()["digest"]
    assert save(client, TEXT + "# Bob\n", digest, "Bob").status_code == 200
    answer = save(client, TEXT + "# Ann\n", digest)
    assert (answer.status_code, answer.json()["code"]) == (409, "changed")
    assert "by Bob at 20" in answer.json()["message"]
    (lab / NAME).write_text(TEXT + "# vi\n", encoding="utf-8")
    answer = save(client, TEXT + "# Ann\n", digest)
    assert "by another program at 20" in answer.json()["message"]
    assert (lab / NAME).read_text(encoding="utf-8") == TEXT + "# vi\n"


def test_only_one_of_concurrent_saves_succeeds(client):
    digest = open_text(client).json()["digest"]
    begin, codes = threading.Barrier(8), []

    def write(number):
        begin.wait()
        codes.append(save(client, TEXT + f"# {number}\n", digest, f"P{number}").status_code)

    threads = [threading.Thread(target=write, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(codes) == [200] + 7 * [409]


@pytest.mark.parametrize(
    "name",
    ["../x.yaml", "/etc/x.yaml", "procedures/../../x.yaml", "a/b/x.yaml", "x.txt", ".x.yaml",
     "x\0.yaml", "procedures/.x.yaml", "C:x.yaml", "..\\x.yaml", "nul.yaml",
     "procedures/Con.x.yaml", SHIPPED, "x" * 150 + ".yaml"],
)  # fmt: skip
def test_invalid_file_name_is_refused(client, lab, name):
    answer = save(client, TEXT, "", procedure=name)
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid")
    assert open_text(client, name).status_code == (200 if name == SHIPPED else 404)
    assert sorted(path.name for path in lab.parent.rglob("*.y*ml")) == ["sweep.yaml"]


def test_links_out_of_the_lab_are_neither_read_nor_written(client, lab, tmp_path):
    outside = tmp_path / "outside.yaml"
    outside.write_text(TEXT, encoding="utf-8")
    (lab / "link.yaml").symlink_to(outside)
    (lab / "stations").symlink_to(tmp_path)
    for name in ("link.yaml", "stations/outside.yaml"):
        answer = open_text(client, name)
        assert answer.status_code == 422, name
        assert "is outside the lab's folder" in answer.json()["message"]
        answer = save(client, TEXT + "#\n", sha256(outside), procedure=name)
        assert answer.status_code == 422, name
        assert post(client, "check", procedure=name, text=TEXT).status_code == 422
    assert outside.read_text(encoding="utf-8") == TEXT
    (lab / "procedures" / "inner.yaml").symlink_to(lab / NAME)
    answer = save(client, TEXT + "#\n", sha256(lab / NAME), procedure="procedures/inner.yaml")
    assert answer.status_code == 200
    assert (lab / "procedures" / "inner.yaml").is_symlink()
    assert (lab / NAME).read_text(encoding="utf-8") == TEXT + "#\n"


def test_text_that_is_no_procedure_is_refused(client, lab):
    digest = open_text(client).json()["digest"]
    answer = save(client, "rigrunner: station/1\n", digest)
    assert "is not marked as a procedure" in answer.json()["message"]
    long = TEXT + "#" + "ü" * (MAX_BYTES // 2)
    assert save(client, long, digest).status_code == 413
    assert save(client, TEXT + "#" * MAX_BYTES, digest).status_code == 400
    assert save(client, TEXT, "no digest").status_code == 400
    assert save(client, TEXT, digest, " ").status_code == 400
    (lab / "station.yaml").write_text("rigrunner: station/1\n", encoding="utf-8")
    answer = save(client, TEXT, "", procedure="station.yaml")
    assert (answer.status_code, answer.json()["code"]) == (409, "wrong_state")
    (lab / NAME).write_bytes(TEXT.encode() + b"# \xff\n")
    assert (open_text(client).status_code, open_text(client).json()["code"]) == (422, "invalid")
    assert "UTF-8" in open_text(client).json()["problems"][0]["message"]


@pytest.mark.parametrize("quote", ['"', "'"])
def test_station_with_quoted_procedure_mark_is_not_saved(client, lab, quote):
    # in YAML a quoted text may continue at the beginning of a line
    text = f"rigrunner: station/1\nid: evil\ntitle: {quote}x\nrigrunner: procedure/2\n{quote}\n"
    answer = save(client, text, "", procedure="evil.yaml")
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid")
    assert not (lab / "evil.yaml").exists()


def test_link_at_a_temporary_file_is_not_followed(client, lab, tmp_path):
    outside = tmp_path / "outside.txt"
    outside.write_text("mine", encoding="utf-8")
    (lab / "procedures/.sweep.yaml.part").symlink_to(outside)
    digest = open_text(client).json()["digest"]
    assert save(client, TEXT + "# more\n", digest).status_code == 200
    file = approval_file(lab / NAME)
    file.with_name(f".{file.name}.part").symlink_to(outside)
    sha256_seen = open_text(client).json()["sha256"]
    assert post(client, "approve", sha256=sha256_seen, by="Ann").status_code == 200
    assert open_text(client).json()["state"] == "approved"
    assert outside.read_text(encoding="utf-8") == "mine"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes on Windows")
def test_named_pipe_in_the_folder_does_not_block(client, lab):
    os.mkfifo(lab / "pipe.yaml")
    answers = []
    ask = threading.Thread(
        target=lambda: answers.append(client.get("/api/v1/procedures")), daemon=True
    )
    ask.start()
    ask.join(30)
    assert [answer.status_code for answer in answers] == [200]


def test_lone_surrogates_are_refused(client):
    digest = open_text(client).json()["digest"]
    body = '{"procedure": "a.yaml", "text": "rigrunner: procedure/2\\n# \\ud800", "by": "A"}'
    headers = {**ANN, "Content-Type": "application/json"}
    answer = client.post("/api/v1/procedures/save", content=body, headers=headers)
    assert answer.status_code == 400
    assert open_text(client).json()["digest"] == digest


def test_check_reports_the_same_problems_as_the_command(client, lab):
    (lab / NAME).write_text(WRONG, encoding="utf-8")
    printed = call("check", lab / NAME).err
    check = post(client, "check", text=WRONG).json()
    assert not check["ok"]
    assert {(problem["line"], problem["file"]) for problem in check["problems"]} >= {(4, "")}
    for problem in check["problems"]:
        assert f"sweep.yaml:{problem['line']}:{problem['column']}: " in printed
        assert problem["message"] in printed


def test_unsaved_text_is_checked_and_planned(client, lab):
    fast = TEXT.replace("cycles: 30", "cycles: 20")
    assert post(client, "check", text=fast, station="simulated").json()["ok"]
    plan = client.post(
        "/api/v1/plan", json={"procedure": NAME, "station": "simulated", "text": fast}
    ).json()
    (lab / "fast.yaml").write_text(fast, encoding="utf-8")
    expected = planned_run(lab / "fast.yaml", find_station("simulated")).plan.estimated_s
    assert plan["estimated_s"] == pytest.approx(expected)
    assert (lab / NAME).read_text(encoding="utf-8") == TEXT
    heavy = TEXT.replace("channel: tester.torque", "channel: tester.torqu", 1)
    check = post(client, "check", text=heavy, station="simulated").json()
    with pytest.raises(InvalidFileError) as refused:
        planned_run(lab / NAME, find_station("simulated"), text=heavy)
    assert [problem["message"] for problem in check["problems"]] == [
        problem.message for problem in refused.value.problems
    ]


@pytest.mark.thorough
def test_text_is_compared_with_the_last_or_the_approved_run(client, lab):
    nothing = post(client, "compare", text=TEXT).json()
    assert (nothing["run"], nothing["changes"]) == ("", [])
    words = ("run", lab / NAME, "--station", "simulated", "--runs", lab / "runs", "--unattended")
    assert call("approve", lab / NAME, "--by", "Ann").code == 0
    call(*words)
    (approved,) = (path.name for path in (lab / "runs").iterdir())
    (lab / NAME).write_text(TEXT.replace("cycles: 30", "cycles: 20"), encoding="utf-8")
    call(*words)
    comparison = post(client, "compare", text=TEXT.replace("cycles: 30", "cycles: 10")).json()
    assert (comparison["against"], comparison["run"]) == ("approved", approved)
    assert not comparison["same"]
    texts = [change["text"] for change in comparison["changes"]]
    assert any("30" in text and "10" in text for text in texts)
    same = post(client, "compare", text=TEXT + "# only a remark\n").json()
    assert (same["same"], same["changes"]) == (True, [])
    assert same["verdict"].startswith("the only differences")
    (lab / "procedures" / "sweep.approval.json").unlink()
    comparison = post(client, "compare", text=TEXT.replace("cycles: 30", "cycles: 10")).json()
    assert comparison["against"] == "run"
    assert comparison["run"] != approved
    assert any("20" in change["text"] for change in comparison["changes"])
    mine = post(client, "compare", text=TEXT, against="file").json()
    assert (mine["against"], mine["same"]) == ("file", False)


def test_only_the_text_that_was_opened_is_approved(client, lab):
    procedure = open_text(client).json()
    (lab / NAME).write_text(TEXT + "# later\n", encoding="utf-8")
    answer = post(client, "approve", sha256=procedure["sha256"], by="Cora")
    assert (answer.status_code, answer.json()["code"]) == (409, "changed")
    assert open_text(client).json()["state"] == "draft"
    procedure = open_text(client).json()
    assert post(client, "approve", sha256=procedure["sha256"], by="Cora").status_code == 200
    assert "approved by Cora" in open_text(client).json()["approval"]
    assert "approved by Cora" in call("approve", lab / NAME, "--show").out


def test_shipped_procedure_cannot_be_approved(client):
    procedure = open_text(client, SHIPPED).json()
    answer = post(client, "approve", procedure=SHIPPED, sha256=procedure["sha256"], by="Cora")
    assert answer.status_code == 422


def test_editors_of_one_file_see_each_other(client, panel, lab):
    assert post(client, "edit", by="").status_code == 200
    client.post("/api/v1/procedures/edit", json={"procedure": NAME, "by": "Bob"}, headers=BOB)
    (edited,) = panel.rig("simulated").board.get("editing")
    assert [editor.name for editor in edited.editors] == ["", "Bob"]
    assert (edited.procedure, edited.digest) == (NAME, sha256(lab / NAME))
    save(client, TEXT + "#\n", edited.digest)
    (edited,) = panel.rig("simulated").board.get("editing")
    assert (edited.digest, edited.changed_by) == (sha256(lab / NAME), "Ann")
    (lab / NAME).write_text(TEXT, encoding="utf-8")
    panel.tick()
    (edited,) = panel.rig("simulated").board.get("editing")
    assert (edited.digest, edited.changed_by) == (sha256(lab / NAME), "")
    assert edited.approved_utc == ""
    sha256_seen = open_text(client).json()["sha256"]
    assert post(client, "approve", sha256=sha256_seen, by="C").status_code == 200
    panel.tick()
    (edited,) = panel.rig("simulated").board.get("editing")
    assert edited.approved_utc.startswith("20")
    client.post("/api/v1/procedures/leave", json={}, headers=BOB)
    (edited,) = panel.rig("simulated").board.get("editing")
    assert len(edited.editors) == 1


def test_schema_of_procedures_is_served(client):
    schema = client.get("/api/v1/procedures/schema").json()
    shipped = Path(__file__).parents[3] / "procedures/procedure.schema.json"
    assert schema.keys() >= {"$defs", "properties"}
    assert shipped.read_text(encoding="utf-8").count("settle") > 0
    assert "settle" in schema["$defs"]["Step"]["properties"]


def test_deleted_file_can_be_saved_again(client, lab):
    digest = open_text(client).json()["digest"]
    (lab / NAME).unlink()
    assert save(client, TEXT, digest).status_code == 409
    assert save(client, TEXT, "").status_code == 200
    assert (lab / NAME).read_text(encoding="utf-8") == TEXT
