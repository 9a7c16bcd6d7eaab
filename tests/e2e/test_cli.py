"""The command line as a person uses it, on the shipped procedures and the simulated station."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys

import pytest

from helpers_cli import call
from rigrunner import __version__
from rigrunner.api.errors import ExitCode
from rigrunner.run.locate import find_procedure, find_station

LOADED = "starting_torque_1000n"
NO_LOAD = "no_load_inertia_sweep"
SHIPPED_PLUGINS = (
    *("swing_tester_sim", "swing_tester_ode", "replay"),
    *("grubbs", "generalized_esd", "pauta", "chauvenet", "mad", "none"),
    *("polynomial", "basis", "aicc", "expression", "inertia_physical", "pchip"),
    *("paper_peak", "template_inverse", "energy", "html"),
)
SWEEP = [1, 3, 5, 8, 10, 15, 18, 20, 25, 30, 33, 35]


def document(path):
    return json.loads((path / "result.json").read_text(encoding="utf-8"))


def test_demo_leaves_two_sealed_runs_and_a_report(demo):
    for run in (demo.no_load, demo.loaded):
        names = {entry.name for entry in run.iterdir()}
        assert names == {"run.h5", "result.json", "report.html", "run.log"}
    assert str(demo.loaded / "report.html") in demo.called.out


def test_demo_prints_raw_and_compensated_torque_by_frequency(demo):
    rows = re.findall(r"^ +(\d+) Hz +([\d.]+) +(.*)$", demo.called.out, re.MULTILINE)
    assert [int(row[0]) for row in rows[-len(SWEEP) :]] == SWEEP
    raw_at_35_hz = float(rows[-1][1])
    # The paper's simulation gives 5.7 N·m at the sensor, without support friction.
    assert 5.7 < raw_at_35_hz < 9
    assert all(len(line) <= 80 for line in demo.called.out.splitlines() if " Hz " in line)


def test_headline_is_the_torque_of_the_bearing(demo):
    headline = document(demo.loaded)["headline"]
    truth_nm = 0.7262  # of the paper's simulation, and the simulated rig's own
    assert headline["compensated"]["value"] == pytest.approx(truth_nm, abs=0.02)
    assert headline["raw_peak"]["value"] > 2


def test_the_runs_are_listed(demo):
    called = call("runs", "--runs", demo.folder)
    assert called.code == ExitCode.PASS
    assert [line.split()[0] for line in called.out.splitlines()[2:]] == [
        demo.no_load.name,
        demo.loaded.name,
    ]
    listed = json.loads(call("runs", "--runs", demo.folder, "--json").out)
    assert [run["outcome"] for run in listed] == ["completed", "completed"]
    assert [len(run["recordings"]) for run in listed] == [12, 12]


def test_unreadable_run_is_listed(demo, tmp_path):
    shutil.copytree(demo.no_load, tmp_path / "broken")
    (tmp_path / "broken" / "run.h5").chmod(0o644)
    (tmp_path / "broken" / "run.h5").write_bytes(b"not HDF5")
    called = call("runs", "--runs", tmp_path)
    assert called.code == ExitCode.PASS
    assert "unreadable" in called.out


def test_missing_folder_of_runs_is_not_an_error(tmp_path):
    called = call("runs", "--runs", tmp_path / "none")
    assert called.code == ExitCode.PASS
    assert called.out == ""
    assert f"no runs in {tmp_path / 'none'}: there is no such folder" in called.err


@pytest.mark.parametrize("by", ["name", "start of the name", "folder", "file"])
def test_a_run_is_shown(demo, by):
    words = {
        "name": demo.loaded.name,
        "start of the name": demo.loaded.name.rpartition("_")[0],
        "folder": str(demo.loaded),
        "file": str(demo.loaded / "run.h5"),
    }
    called = call("show", words[by], "--runs", demo.folder)
    assert called.code == ExitCode.PASS
    assert demo.loaded.name in called.out
    assert "DEMO-0001" in called.out
    assert "template_inverse" in called.out


def test_run_is_shown_as_json(demo):
    shown = json.loads(call("show", demo.loaded, "--json").out)
    assert shown["sealed"] is True
    assert shown["partner_runs"]["no_load"]["run"] == demo.no_load.name
    assert shown["result"] == document(demo.loaded)


def test_an_unknown_run_gets_a_suggestion(demo):
    mistyped = demo.loaded.name.replace("SSPB", "SSBP")
    called = call("show", mistyped, "--runs", demo.folder)
    assert called.code == ExitCode.USAGE
    assert f"did you mean '{demo.loaded.name}'?" in called.err


def test_stored_run_gives_the_same_result(quick):
    called = call("analyse", quick.loaded, "--json")
    assert called.code == ExitCode.PASS
    assert json.loads(called.out) == document(quick.loaded)


@pytest.mark.thorough
def test_analysis_is_written_to_a_new_file(demo, tmp_path):
    out = tmp_path / "again.json"
    assert call("analyse", demo.loaded, "--out", out).code == ExitCode.PASS
    assert json.loads(out.read_text(encoding="utf-8")) == document(demo.loaded)
    called = call("analyse", demo.loaded, "--out", out)
    assert called.code == ExitCode.USAGE
    assert "never overwritten" in called.err


def test_existing_output_file_is_refused_before_the_analysis(tmp_path):
    out = tmp_path / "result.json"
    out.touch()
    called = call("analyse", "no-such-run", "--out", out)
    assert called.code == ExitCode.USAGE
    assert "never overwritten" in called.err


@pytest.mark.thorough
@pytest.mark.usefixtures("drawn_figures")
def test_report_is_reproduced_byte_for_byte(demo, tmp_path):
    out = tmp_path / "again.html"
    called = call("report", demo.loaded, "--out", out)
    assert called.code == ExitCode.PASS
    assert called.out.strip() == str(out)
    assert out.read_bytes() == (demo.loaded / "report.html").read_bytes()


@pytest.mark.parametrize("procedure", [NO_LOAD, LOADED])
def test_shipped_procedures_fit_the_shipped_station(procedure):
    called = call("check", procedure, "--station", "simulated")
    assert called.code == ExitCode.PASS, called.err
    assert "can be run on simulated" in called.out


def test_plan_shows_actions_torque_time_and_disk_space():
    called = call("plan", LOADED, "--station", "simulated")
    assert called.code == ExitCode.PASS, called.err
    assert "35 Hz" in called.out
    assert "MB" in called.out
    planned = json.loads(call("plan", LOADED, "--station", "simulated", "--json").out)
    assert [step["do"] for step in planned["steps"]].count("record") == len(SWEEP)
    assert sum(step["estimated_s"] for step in planned["steps"]) == planned["estimated_s"]


def test_missing_no_load_run_is_reported_with_the_option(tmp_path):
    called = call("run", LOADED, "--station", "simulated", "--runs", tmp_path, "--unattended")
    assert called.code == ExitCode.DATA
    assert "SSPB-NLI" in called.err
    assert "--partner no_load=RUN" in called.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_run_is_compensated_with_the_given_no_load_run(demo, tmp_path):
    called = call(
        "run", LOADED, "--station", "simulated", "--runs", tmp_path, "--unattended",
        "--no-load", demo.no_load, "--set", "specimen=SN-17", "--json",
    )  # fmt: skip
    assert called.code == ExitCode.PASS, called.err
    result = json.loads(called.out)
    assert result["run"]["inputs"]["specimen"] == "SN-17"
    assert result["no_load_run"]["id"] == demo.no_load.name
    assert next(tmp_path.iterdir()).name.endswith("SN-17")


def test_loaded_run_is_refused_as_no_load_run(demo, tmp_path):
    called = call(
        "run", LOADED, "--station", "simulated", "--runs", tmp_path, "--unattended",
        "--no-load", demo.loaded,
    )  # fmt: skip
    assert called.code == ExitCode.DATA
    assert "SSPB-NLI" in called.err


def test_an_unknown_input_gets_a_suggestion(tmp_path):
    called = call(
        "run", NO_LOAD, "--station", "simulated", "--runs", tmp_path, "--unattended",
        "--set", "oprator=me",
    )  # fmt: skip
    assert called.code == ExitCode.USAGE
    assert "did you mean 'operator'?" in called.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run", "starting_torque", "--station", "simulated"], "did you mean"),
        (["run", LOADED, "--station", "simulatd"], "did you mean 'simulated'?"),
        (["run", LOADED], "--station"),
        (["check", "no/such/file.yaml"], "no/such/file.yaml"),
        (["plugins", "template_invers"], "did you mean 'template_inverse'?"),
        (["show", "nothing"], "there is no run 'nothing'"),
    ],
)
def test_mistyped_argument_is_a_usage_error_with_a_hint(words, said):
    called = call(*words)
    assert called.code in (ExitCode.USAGE, ExitCode.INVALID)
    assert said in called.err
    assert called.out == ""


def test_problems_of_a_file_are_reported_with_their_place(tmp_path):
    text = find_procedure(LOADED).read_text(encoding="utf-8")
    text = text.replace("  load: 1000 N\n", "  load: 1000 Nm\n").replace("settle:", "setle:")
    path = tmp_path / "bad.yaml"
    path.write_text(text, encoding="utf-8")
    called = call("check", path, "--station", "simulated")
    assert called.code == ExitCode.INVALID
    assert re.search(rf"{re.escape(str(path))}:\d+:\d+: error:", called.err)
    assert "settle" in called.err


def test_plugins_are_listed_with_their_help():
    called = call("plugins")
    assert called.code == ExitCode.PASS
    assert called.err == ""
    for name in SHIPPED_PLUGINS:
        assert re.search(rf"^  {name}  ", called.out, re.MULTILINE), name


def test_a_plugins_settings_are_shown():
    assert "published" in call("plugins", "paper_peak").out
    schema = json.loads(call("plugins", "paper_peak", "--json").out)[0]["settings"]
    assert "coefficients" in schema["properties"]


def test_python_m_rigrunner_works():
    done = subprocess.run(
        [sys.executable, "-m", "rigrunner", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"rigrunner {__version__}\n"


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (signal.SIGHUP, ExitCode.ABORTED),  # the others are sent in test_signals.py too
        pytest.param(signal.SIGTERM, ExitCode.ABORTED, marks=pytest.mark.thorough),
        pytest.param(signal.SIGINT, ExitCode.INTERRUPTED, marks=pytest.mark.thorough),
    ],
)
def test_signal_stops_a_run_and_leaves_a_sealed_folder(tmp_path, number, code):
    words = ["run", NO_LOAD, "--station", "simulated", "--unattended", "--realtime"]
    with subprocess.Popen(
        [sys.executable, "-m", "rigrunner", *words, "--runs", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        try:
            wait_for_line(child.stderr, "Settle")
            child.send_signal(number)
            out, err = child.communicate(timeout=200)
        finally:
            child.kill()
    assert child.returncode == code, err
    assert str(tmp_path) in out
    (run,) = tmp_path.iterdir()
    assert (run / "run.h5").exists()
    assert not (run / "result.json").exists()
    assert "abort" in (run / "run.log").read_text(encoding="utf-8")


def wait_for_line(stream, word):
    for line in stream:
        if word in line:
            return
    raise AssertionError(f"the run ended before '{word}'")


def test_file_of_another_kind_is_refused():
    called = call("check", find_station("simulated"))
    assert called.code == ExitCode.INVALID
    assert "hint: this is a file of the kind 'station'; 'procedure' is needed" in called.err
