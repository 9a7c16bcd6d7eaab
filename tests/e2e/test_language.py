"""A procedure with every kind of step, from file to stored run, as a person runs it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import yaml

from helpers_cli import call
from helpers_language import edited, place_of
from rigrunner.api.errors import ExitCode
from rigrunner.procedure import load_procedure
from rigrunner.procedure.kinds import installed_kinds
from rigrunner.run.stored import open_run
from rigrunner.runfile import read

SOURCE = Path(__file__).parent / "language"


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    shutil.copytree(SOURCE, folder, dirs_exist_ok=True)
    (folder / "answers.yaml").write_text("room: 24\nspecimen: SN-17\n".replace("24", "24 °C"))
    return folder


@pytest.fixture(scope="module")
def wide(lab):
    """Run the wide procedure, once; return the call and the run folder."""
    called = call(
        "run", lab / "wide.yaml", "--station", "simulated", "--runs", lab / "runs", "--unattended",
        "--answers", lab / "answers.yaml", "--set", "specimen=X-1",
    )  # fmt: skip
    (folder,) = (lab / "runs").iterdir()
    return called, folder


def test_wide_procedure_has_every_kind_of_step():
    used = set()

    def collect(node):
        if isinstance(node, dict):
            used.update(node)
        for child in node.values() if isinstance(node, dict) else node:
            if isinstance(child, (dict, list)):
                collect(child)

    collect(yaml.safe_load((SOURCE / "wide.yaml").read_text(encoding="utf-8")))
    assert set(installed_kinds().steps) <= used


def test_value_out_of_limits_fails_the_run(wide):
    called, folder = wide
    assert called.code == ExitCode.FAIL, called.err
    assert "out of limits: tester.humidity is 4" in called.err
    info = read(folder).info
    assert (info.outcome, info.reason) == ("completed", "")


def test_answers_come_from_file_command_line_and_procedures(wide):
    assert read(wide[1]).header.inputs == {
        "specimen": "X-1",
        "room": "24 °C",
        "operator": "Demo operator",
        "side": "left",
        "oil": "40 °C",
    }


def test_all_measured_values_are_stored_with_set_points(wide):
    tables = [
        (row.name, row.setpoints["tester.load"]) for row in open_run(wide[1]).data.measurements
    ]
    assert tables == [
        ("rest", 1000.0),
        ("air", 1000.0),
        ("still", 1000.0),
        ("still", 1000.0),
        ("cell", 500.0),
        ("cell", 1000.0),
        ("recorded", 1000.0),
        ("recorded", 1000.0),
    ]
    shown = call("show", wide[1])
    assert "Measured: still" in shown.out
    listed = json.loads(call("show", wide[1], "--json").out)["measurements"]
    assert [row["name"] for row in listed] == [name for name, _ in tables]
    (air,) = [row for row in listed if row["name"] == "air"]
    (limit,) = air["limits"]
    assert (limit["of"], limit["maximum"], limit["verdict"]) == ("tester.humidity", 0.1, "fail")


def test_log_has_notes_attempts_and_calls(wide):
    log = (wide[1] / "run.log").read_text(encoding="utf-8")
    assert "asked: $load applied as shown?" in log
    assert "setup[3].note: note: Grease was renewed before this run." in log
    assert "marginal (limit: 23.1 °C or less" in log
    assert log.count("(limit: 10 % or less)") == 1  # a reading out of limits is not repeated
    order = [
        "call.setup[0]",
        "call.main[1]",
        "call.teardown[1]",
        "main[1].ramp",
        "teardown[1].ramp",
    ]
    places = [log.index(text) for text in order]
    assert places == sorted(places)


def test_texts_of_called_procedures_are_stored(wide, lab):
    header = read(wide[1]).header
    assert header.called_texts == {
        "running_in.yaml": (lab / "running_in.yaml").read_text(encoding="utf-8")
    }
    assert header.procedure_text == load_procedure(lab / "wide.yaml").text


def test_plan_shows_ramp_targets(lab):
    called = call("plan", lab / "wide.yaml", "--station", "simulated")
    assert called.code == ExitCode.PASS, called.err
    assert "0 to 1000 N" in called.out
    assert "Ramp tester.load to 1000 N in 10 s" in called.out


@pytest.mark.parametrize(
    ("changes", "code", "said"),
    [
        ({"--answers": "room: 24\n"}, ExitCode.INVALID, "answers.yaml:1:7: error: room: got 24"),
        ({"--answers": "rom: 24 °C\n"}, ExitCode.INVALID, "did you mean 'room'?"),
        ({"--set": "room=5 N"}, ExitCode.USAGE, "'5 N' is a force, not a temperature"),
        ({"--set": "side=left"}, ExitCode.USAGE, "WIDE has no input 'side'"),
    ],
)
def test_wrong_answer_is_refused_before_the_run(lab, tmp_path, changes, code, said):
    words = []
    for option, value in changes.items():
        if option == "--answers":
            (tmp_path / "answers.yaml").write_text(value, encoding="utf-8")
        words += [option, tmp_path / "answers.yaml" if option == "--answers" else value]
    called = call(
        "run", lab / "wide.yaml", "--station", "simulated", "--runs", tmp_path / "runs",
        "--unattended", *words,
    )  # fmt: skip
    assert called.code == code
    assert said in called.err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rate: 100 N/s", "rate: 900 N/s", "it needs 2 s for this ramp"),
        ("max: 10 %", "max: 10 N", "tester.humidity takes a ratio"),
        ("load: 200 N", "load: 9 kN", "9 kN is out of range (0 to 3 kN)"),
        ("picture: rig.svg", "picture: ../rig.svg", "is outside this file's folder"),
    ],
)
def test_mismatch_with_the_station_is_reported_with_its_place(lab, old, new, said):
    text = (lab / "wide.yaml").read_text(encoding="utf-8")
    (lab / "bad.yaml").write_text(edited(text, (old, new)), encoding="utf-8")
    called = call("check", lab / "bad.yaml", "--station", "simulated")
    assert called.code == ExitCode.INVALID
    assert said in called.err
    value = old.partition(" ")[2]
    line, column = place_of(text, old).split(":")
    assert f"bad.yaml:{line}:{int(column) + len(old) - len(value)}" in called.err
