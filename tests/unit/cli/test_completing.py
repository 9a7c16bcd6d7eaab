"""The completions that a shell offers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest
from click.shell_completion import BashComplete

from helpers_cli import call
from rigrunner.cli.completing import PROGRAM, VARIABLE
from rigrunner.cli.main import rigrunner

PROCEDURES = ["no_load_inertia_sweep", "starting_torque_1000n"]


def offered(*words):
    """Return the completions of the last word: values, or (type, value) if not plain."""
    shell = BashComplete(rigrunner, {}, PROGRAM, VARIABLE)
    items = shell.get_completions(list(words[:-1]), words[-1])
    return [item.value if item.type == "plain" else (item.type, item.value) for item in items]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("mine.yaml", "station.yml", "notes.txt"):
        (tmp_path / name).touch()
    for name in ("20260101T000000Z_A", "20260102T000000Z_B"):
        (tmp_path / "runs" / name).mkdir(parents=True)
    (tmp_path / "elsewhere" / "20250101T000000Z_C").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)


def test_commands_are_completed():
    assert offered("") == list(rigrunner.summaries)
    assert offered("sch") == ["schema"]


@pytest.mark.parametrize("command", ["run", "check", "plan"])
@pytest.mark.usefixtures("folder")
def test_shipped_procedures_and_files_of_the_folder_are_completed(command):
    words = offered(command, "")
    assert set(PROCEDURES) < set(words)
    assert words[-2:] == ["mine.yaml", "station.yml"]
    assert offered(command, "mi") == ["mine.yaml"]


@pytest.mark.parametrize("command", ["run x", "check x", "plan x", "plugins", "schema station"])
@pytest.mark.usefixtures("folder")
def test_shipped_stations_are_completed(command):
    assert "simulated" in offered(*command.split(), "--station", "simu")


@pytest.mark.parametrize("command", ["run", "show"])
@pytest.mark.usefixtures("folder")
def test_paths_are_left_to_the_shell(command):
    assert offered(command, "some/where") == [("file", "some/where")]


@pytest.mark.parametrize("command", ["show", "report", "analyse"])
@pytest.mark.usefixtures("folder")
def test_stored_runs_are_completed_newest_first(command):
    assert offered(command, "2026") == ["20260102T000000Z_B", "20260101T000000Z_A"]
    assert offered(command, "--runs", "elsewhere", "") == ["20250101T000000Z_C"]


@pytest.mark.parametrize("command", ["run x", "analyse x"])
@pytest.mark.usefixtures("folder")
def test_no_load_run_is_completed(command):
    assert offered(*command.split(), "--no-load", "20260102") == ["20260102T000000Z_B"]


def test_plugins_languages_shells_and_options_are_completed():
    assert offered("plugins", "template") == ["template_inverse"]
    assert offered("schema", "") == [
        *("procedure", "station", "import", "letterhead", "order", "certificate"),
    ]
    assert offered("completion", "") == ["bash", "zsh", "fish"]
    assert "--unattended" in offered("run", "--un")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_has_a_completion_script(shell):
    result = call("completion", shell)
    assert result.code == 0
    assert f"{VARIABLE}={shell}_complete" in result.out


def run_completion(instruction, words):
    environment = {"COMP_WORDS": words, "COMP_CWORD": str(len(words.split()))}
    return subprocess.run(
        [sys.executable, "-m", "rigrunner"],
        env=os.environ | environment | {VARIABLE: instruction},
        capture_output=True,
        text=True,
        check=False,
    )


def test_failed_completion_prints_nothing():
    result = run_completion("bash_complete", "rigrunner no_such_command")
    assert (result.returncode, result.stdout, result.stderr) == (1, "", "")
    assert run_completion("csh_complete", "rigrunner").returncode == 1


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")
def test_bash_completes_a_procedure(tmp_path):
    program = tmp_path / "rigrunner"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m rigrunner "$@"\n')
    program.chmod(0o755)
    script = """
        eval "$(rigrunner completion bash 2>/dev/null)"
        COMP_WORDS=(rigrunner run starting) COMP_CWORD=2
        _rigrunner_completion rigrunner
        printf '%s' "${COMPREPLY[*]}"
    """
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    result = subprocess.run(
        ["bash", "-c", script],
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert result.stdout == "starting_torque_1000n"


@pytest.mark.parametrize(
    "words",
    ["", "run ", "check ", "plan ", "show ", "analyse ", "report ", "run x --station ", "schema "],
)
def test_completion_imports_no_heavy_package(words):
    code = (
        "import sys; from rigrunner.cli.main import main; main()\n"
        "print(*{name.partition('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    line, word = f"rigrunner {words}", str(len(words.split()) + 1)
    environment = {"COMP_WORDS": line, "COMP_CWORD": word, VARIABLE: "bash_complete"}
    result = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert {"numpy", "scipy", "h5py", "pydantic", "rich"}.isdisjoint(result.stderr.split())
