"""The folder that `rigrunner init` creates works with the commands that it prints."""

from __future__ import annotations

import shutil

import pytest

from helpers_cli import call, shell
from helpers_docs import code_blocks
from rigrunner.api.errors import ExitCode
from rigrunner.runfile import read

pytestmark = pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")


@pytest.fixture(scope="module")
def printed(lab_begun, tmp_path_factory):
    folder = tmp_path_factory.mktemp("somewhere")
    shutil.copytree(lab_begun.folder, folder / "bench 1")
    return folder, lab_begun.commands


@pytest.mark.thorough
def test_printed_commands_work_unchanged(lab_begun):
    assert "N·m (95 %, template_inverse)" in lab_begun.printed
    runs = sorted((lab_begun.folder / "runs").iterdir())
    assert [(run / "report.html").is_file() for run in runs] == [True, True, False]
    measured = read(runs[-1]).measurements[0].values["room.temperature"]
    assert 294 < measured < 296.3


@pytest.mark.thorough
def test_readme_commands_work(printed):
    folder, commands = printed
    blocks = [block.code for block in code_blocks(folder / "bench 1" / "README.md")]
    assert blocks[0] == commands.partition("\n")[2]
    for block in blocks[1:]:
        shell(folder / "bench 1", block)


@pytest.mark.thorough
def test_readme_of_reports_gives_a_certificate_and_an_own_report(printed):
    lab = printed[0] / "bench 1"
    outputs = [
        shell(lab, block.code).stdout for block in code_blocks(lab / "reports" / "README.md")
    ]
    assert "MATCH" in outputs[0].splitlines()
    (run,) = (lab / "runs").glob("*SSPB-STT-1000*")
    assert outputs[1].strip() == str(run.relative_to(lab) / "report.csv")
    assert (run / "report.csv").read_text(encoding="utf-8").startswith("method,frequency in Hz")


def test_init_twice_is_refused(tmp_path):
    assert call("init", tmp_path / "bench 1").code == ExitCode.PASS
    called = call("init", tmp_path / "bench 1")
    assert called.code == ExitCode.USAGE
    assert "files are never overwritten" in called.err
    assert called.out == ""


def test_init_in_the_current_folder_prints_no_cd(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert not [line for line in call("init", ".").out.splitlines() if line.startswith("cd")]


@pytest.mark.thorough
def test_new_drop_in_plugin_works_in_the_lab(tmp_path):
    lab = tmp_path / "lab"
    commands = (
        "rigrunner init lab && cd lab && rigrunner new device press --drop-in\n"
        "sed -i 's/^devices:/devices:\\n  press: {type: press, plugin: press,"
        " settings: {simulated: yes}}/' station.yaml\n"
        "rigrunner plugins press --station station.yaml\n"
        "rigrunner check-plugin press --station station.yaml --role press --yes\n"
        "sed 's/room: thermometer/press: press/; s/room.temperature/press.force/'"
        " procedures/room_temperature.yaml > procedures/press.yaml\n"
        "rigrunner run procedures/press.yaml --station station.yaml --unattended\n"
    )
    shown = shell(tmp_path, commands).stdout
    assert ", 0 fail, " in shown
    (run,) = (lab / "runs").iterdir()
    assert read(run).measurements[0].values == {"press.force": 0.0}
