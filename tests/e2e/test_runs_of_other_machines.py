"""A run from another machine: its data are read, and no code named in it is run."""

from __future__ import annotations

import shutil

import pytest

from helpers_cli import call
from helpers_workflow import quick_procedure, run, station_file
from rigrunner.api.errors import ExitCode, InvalidFileError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run

LAB_PLUGIN = '''
"""A tester and a fit of a lab's own; says when it is imported."""
from dataclasses import replace
from pathlib import Path

from rigrunner.api.hooks import DeviceRecord, hookimpl
from rigrunner_plugins.fits import records

api_version = 1

(Path(__file__).parent / "was_imported").touch()


def make(settings, context):
    return context.make("swing_tester_sim", {"seed": 1})


@hookimpl
def rigrunner_devices():
    return [DeviceRecord(name="lab_tester", help="A tester", factory=make, simulated=True)]


@hookimpl
def rigrunner_fits():
    (polynomial,) = (each for each in records.rigrunner_fits() if each.name == "polynomial")
    return [replace(polynomial, name="lab_fit")]
'''


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A folder of a lab with its plugins, and a run that needs them."""
    folder = tmp_path_factory.mktemp("lab")
    (folder / "plugins").mkdir()
    (folder / "plugins" / "own.py").write_text(LAB_PLUGIN, encoding="utf-8")
    station = station_file(
        folder,
        ("plugin: swing_tester_sim", "plugin: lab_tester"),
        ("settings: {seed: 1}", "settings: {}"),
        ("id: simulated", "plugins: plugins\nid: simulated"),
    )
    procedure = quick_procedure(folder, "no_load_inertia_sweep", ("polynomial:", "lab_fit:"))
    finished = run(procedure, folder / "runs", station=station)
    return folder, finished.folder


@pytest.fixture
def sent(lab, tmp_path, monkeypatch):
    """The run as received elsewhere, with the plugins next to it; this is the working folder."""
    folder, recorded = lab
    (folder / "plugins" / "was_imported").unlink(missing_ok=True)
    shutil.copytree(recorded, tmp_path / "run")
    for place in (tmp_path, tmp_path / "run"):
        shutil.copytree(folder / "plugins", place / "plugins")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "run"


def imports(folder):
    return list(folder.rglob("was_imported"))


@pytest.mark.parametrize("command", ["analyse", "report"])
def test_plugin_that_is_not_installed_is_reported(command, sent):
    called = call(command, sent)
    assert called.code == ExitCode.INVALID, called.err
    assert "there is no fit 'lab_fit'" in called.err
    assert "which is not available: name its station by --station, or install it" in called.err
    assert "Traceback" not in called.err
    assert not imports(sent.parent)


def test_show_and_verify_import_nothing(sent):
    for command in ("show", "verify"):
        called = call(command, sent)
        assert "Traceback" not in called.err
        assert not imports(sent.parent)
    assert "lab_fit" in call("verify", sent).out


def test_naming_the_station_loads_its_plugins(lab, sent):
    folder, _ = lab
    called = call("analyse", sent, "--station", folder / "station.yaml")
    assert called.code == ExitCode.PASS, called.err
    assert imports(folder)
    assert not imports(sent.parent)


@pytest.mark.parametrize("way", ["../plugins", "/", "inside/../../plugins"])
def test_plugins_outside_the_folder_of_the_station_are_refused(way, lab, tmp_path):
    folder, _ = lab
    (folder / "plugins" / "was_imported").unlink(missing_ok=True)
    shutil.copytree(folder / "plugins", tmp_path / "plugins")
    station_folder = tmp_path / "station"
    station_folder.mkdir()
    station = station_file(station_folder, ("id: simulated", f"plugins: {way}\nid: simulated"))
    procedure = quick_procedure(station_folder, "no_load_inertia_sweep")
    with pytest.raises(InvalidFileError) as caught:
        plan_run(procedure, station, load_registry(), SimulatedClock())
    (problem,) = caught.value.problems
    assert "is outside this file's folder" in problem.message
    assert problem.field == "plugins"
    assert not imports(tmp_path)


def test_specimen_with_a_path_and_a_script_stays_a_name(tmp_path, lab):
    folder, _ = lab
    station, hostile = folder / "station.yaml", "../../<script>alert(1)</script>"
    runs = tmp_path / "a" / "b" / "runs"
    text = "specimen: {ask: Bearing serial number, unattended: DEMO-0001}"
    procedure = quick_procedure(
        tmp_path, "no_load_inertia_sweep",
        ("operator: {ask: Your name, unattended: Demo operator}",
         f"operator: {{ask: Your name, unattended: '{hostile}'}}\n  "
         + text.replace("DEMO-0001", f"'{hostile}'")),
    )  # fmt: skip
    finished = run(procedure, runs, station=station)
    assert finished.folder.parent == runs
    assert sorted(path.name for path in runs.iterdir()) == [finished.folder.name]
    called = call("report", finished.folder)
    assert called.code == ExitCode.PASS, called.err
    page = (finished.folder / "report.html").read_text(encoding="utf-8")
    assert hostile not in page
    assert "&lt;script&gt;alert(1)" in page
