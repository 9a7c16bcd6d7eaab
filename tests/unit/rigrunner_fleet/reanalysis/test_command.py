"""`rigrunner reanalyse`: its output, exit codes, and how it continues after Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys

import pytest

from helpers_cli import call
from unit.rigrunner_fleet.reanalysis.helpers_reanalysis import lab_of, results

ANALYSIS = "rigrunner: analysis/1\nanalysis:\n  primary: energy\n"


@pytest.fixture(scope="module")
def lab(quick, tmp_path_factory):
    return lab_of(tmp_path_factory.mktemp("lab"), quick, copies=2)


@pytest.mark.thorough
def test_command_prints_counts_and_writes_a_summary(lab, tmp_path):
    result = call("reanalyse", lab, "--out", tmp_path / "out", "--jobs", "1")
    assert result.code == 0, result.err
    assert result.out.splitlines()[:4] == [
        "analysed        3",
        "skipped         0",
        "failed          0",
        "other verdicts  0",
    ]
    assert "3 of 3 runs" in result.err
    again = call("reanalyse", lab, "--out", tmp_path / "out", "--json")
    assert "3 of 3 runs were done before" in again.err
    assert json.loads(again.out)["analysed"] == 3


@pytest.mark.thorough
def test_failed_runs_are_named_and_exit_with_5(lab, tmp_path):
    (tmp_path / "letter.h5").write_text("dear")
    result = call(
        "reanalyse", lab / "rig-2", tmp_path / "letter.h5", "--out", tmp_path / "out", "--jobs", "1"
    )
    assert result.code == 5
    assert "failed: letter: " in result.err
    assert "analysed        1" in result.out
    assert json.loads((tmp_path / "out/summary.json").read_text())["failed"] == 1


@pytest.mark.thorough
def test_analysis_is_read_from_a_file(lab, tmp_path):
    (tmp_path / "energy.yaml").write_text(ANALYSIS)
    out = tmp_path / "out"
    result = call("reanalyse", lab / "rig-2", "--out", out, "--analysis", tmp_path / "energy.yaml")
    assert result.code == 0, result.err
    assert json.loads(results(out)["loaded-1"])["headline"]["method"] == "energy"


@pytest.fixture
def here(lab, tmp_path, monkeypatch):
    """The current folder, with the runs of two rigs and a file with a typing error."""
    for rig in ("rig-1", "rig-2"):
        (tmp_path / rig).symlink_to(lab / rig)
    (tmp_path / "bad.yaml").write_text(ANALYSIS.replace("primary: energy", "primry: energy"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["nowhere", "--out", "out"], 2, "there is no nowhere"),
        ([".", "--out", "out"], 2, "there is no run in ."),
        (["rig-1"], 2, "--out"),
        (["rig-1", "--out", "rig-2"], 2, "rig-2 is not empty"),
        (["rig-1", "--out", "out", "--analysis", "bad.yaml"], 3, "bad.yaml:3:"),
        (["rig-1", "--out", "out", "--analysis", "none.yaml"], 3, "none.yaml"),
        (["rig-1", "--out", "out", "--dask", "tcp://127.0.0.1:1", "--jobs", "2"], 2, "exclude"),
        (["rig-1", "--out", "out", "--jobs", "0"], 2, "--jobs"),
        (["rig-1", "--out", "out", "--station", "nowhere"], 2, "there is no station"),
    ],
)
def test_invalid_arguments_are_refused(arguments, code, message, here):
    for rig in ("rig-1", "rig-2"):
        if rig not in arguments:
            (here / rig).unlink()
    result = call("reanalyse", *arguments)
    assert (result.code, "Traceback" in result.err) == (code, False)
    assert message in result.err
    assert not (here / "out/summary.csv").exists()


@pytest.mark.thorough
def test_command_continues_after_ctrl_c(lab, tmp_path):
    for number in range(8):
        shutil.copytree(lab / "rig-2/loaded-1", tmp_path / "many" / str(number))
    command = [sys.executable, "-m", "rigrunner", "reanalyse", str(tmp_path / "many")]
    command += ["--jobs", "1", "--out", str(tmp_path / "out")]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        first = next(line for line in process.stderr if " of 8 runs" in line)
        assert first.startswith("1 of 8 runs, ")
        os.kill(process.pid, signal.SIGINT)
        output = process.stderr.read()
    assert process.returncode == 130
    done = int(re.search(r"interrupted from the keyboard: (\d) of 8 runs are done", output)[1])
    assert 1 <= done < 8
    assert "the same command continues with the rest" in output
    assert len(results(tmp_path / "out")) == done
    again = subprocess.run(command, capture_output=True, text=True, check=True)
    assert f"{done} of 8 runs were done before" in again.stderr
    assert len(results(tmp_path / "out")) == 8
