"""A lab's own unit, from the plugin to a run that is read and shown without that plugin."""

from __future__ import annotations

import json
import shutil

import pytest

from helpers_any_quantity import STATION, written
from helpers_cli import shell

PLUGIN = """\
from rigrunner.api.hooks import UnitRecord, hookimpl
from rigrunner.api.unit_tables import UnitDefinition

api_version = 1
DOZEN = UnitDefinition("dozV", "voltage", "kg·m²/(s³·A)", 12.0, spellings=("dozenV",))


@hookimpl
def rigrunner_units():
    return [UnitRecord(name="dozen_volts", help="Twelve volts.", definition=DOZEN)]
"""
CHANGES = [
    ("min: 11.98 V, max: 12.1 V", "min: 0.99 dozV, max: 1.1 dozenV"),
    ("text: output voltage, unit: V", "text: output voltage, unit: dozV"),
]
LAB = STATION.replace("id: bench\n", "id: bench\nplugins: plugins\n").replace(
    "accuracy: 2 mV", "accuracy: 0.0001 dozV"
)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Return a lab with a run in its own unit, whose plugin was removed."""
    folder = tmp_path_factory.mktemp("lab")
    written(folder, *CHANGES, station=LAB)
    (folder / "plugins").mkdir()
    (folder / "plugins" / "dozen.py").write_text(PLUGIN, encoding="utf-8")
    shell(folder, "rigrunner run supply.yaml --station station.yaml --unattended --runs runs")
    shutil.rmtree(folder / "plugins")
    return folder


@pytest.fixture(scope="module")
def run(lab):
    (folder,) = (lab / "runs").iterdir()
    return folder


@pytest.mark.thorough
def test_run_is_shown_in_its_unit_without_the_plugin(lab, run):
    shown = shell(lab, f"rigrunner show {run.name} --runs runs").stdout
    assert "voltage at bench.current = 0 A  pass: 1.00258" in shown  # 12.031 V / 12
    assert "dozV against 0.99 dozV to 1.1 dozV" in shown


@pytest.mark.thorough
def test_report_and_analysis_give_the_same_numbers(lab, run):
    before = json.loads((run / "result.json").read_text("utf-8"))["results"]
    shell(lab, f"rm {run}/report.html; rigrunner report {run.name} --runs runs")
    assert "dozV" in (run / "report.html").read_text("utf-8")
    reanalysed = json.loads(shell(lab, f"rigrunner analyse {run.name} --runs runs --json").stdout)
    assert reanalysed["results"] == before


def test_unit_is_unknown_without_the_plugin(lab):
    station = lab / "station.yaml"
    station.write_text(STATION, encoding="utf-8")
    output = shell(lab, "rigrunner check supply.yaml --station station.yaml 2>&1 || true").stdout
    assert "unknown unit 'dozV'" in output


def test_conflicting_definitions_name_both_plugins(lab):
    folder = lab / "plugins"
    folder.mkdir()
    (folder / "one.py").write_text(PLUGIN, encoding="utf-8")
    (folder / "two.py").write_text(PLUGIN.replace("12.0", "10.0"), encoding="utf-8")
    (lab / "station.yaml").write_text(LAB, encoding="utf-8")
    output = shell(lab, "rigrunner check supply.yaml --station station.yaml 2>&1 || true").stdout
    assert "the unit 'dozV' is defined twice" in output
    assert "one.py (dozV = 12.0" in output
    assert "two.py (dozV = 10.0" in output
    assert "supply.yaml:" in output
