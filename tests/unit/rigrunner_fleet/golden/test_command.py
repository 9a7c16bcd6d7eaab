"""`rigrunner golden` reports a changed compensation of a lab's own plugin."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import pytest

from helpers_cli import call
from helpers_workflow import station_file
from rigrunner.registry import load_registry
from rigrunner.tools.new_plugin import new_plugin
from unit.rigrunner_reports.helpers_html import Page

if TYPE_CHECKING:
    from pathlib import Path

METHOD = "own_method"
ANALYSIS = f"""rigrunner: analysis/1
analysis:
  compensations: [template_inverse, {METHOD}]
  primary: {METHOD}
"""
DIFFERENCE = "model_of(raw.value - rig.value, effects"


@dataclass(frozen=True)
class Lab:
    folder: Path

    @property
    def plugin(self):
        return self.folder / "plugins" / f"{METHOD}.py"

    @property
    def golden(self):
        return self.folder / "golden"

    @property
    def options(self):
        """Options of a command to analyse with the lab's own method."""
        return ["--station", self.folder / "station.yaml", "--analysis", self.folder / "own.yaml"]

    def change(self, difference):
        """Change the difference that the method computes."""
        text = self.plugin.read_text(encoding="utf-8")
        assert DIFFERENCE in text
        changed = text.replace(DIFFERENCE, f"model_of({difference}, effects")
        self.plugin.write_text(changed, encoding="utf-8")


def lab_in(folder, runs):
    """Make a lab with its own method and copies of runs."""
    (folder / "plugins").mkdir(parents=True)
    station_file(folder, ("id: simulated\n", "id: simulated\nplugins: plugins\n"))
    (folder / "own.yaml").write_text(ANALYSIS, encoding="utf-8")
    for run in runs:
        shutil.copytree(run, folder / "runs" / run.name)
    lab = Lab(folder)
    text = new_plugin("compensation", METHOD, load_registry()).module()
    lab.plugin.write_text(text, encoding="utf-8")
    return lab


pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def recorded(quick, tmp_path_factory):
    """A lab with golden runs and copies of their files."""
    lab = lab_in(tmp_path_factory.mktemp("lab"), [quick.no_load, quick.loaded])
    result = call(
        "golden", "record", lab.folder / "runs", "--out", lab.golden, "--copy", "--jobs", "1",
        *lab.options,
    )  # fmt: skip
    assert (result.code, result.out) == (0, f"2 golden runs in {lab.golden}\n"), result.err
    shutil.rmtree(lab.folder / "runs")
    return lab


@pytest.fixture
def lab(recorded, tmp_path):
    shutil.copytree(recorded.folder, tmp_path / "lab")
    return type(recorded)(tmp_path / "lab")


def check(lab, *more):
    return call("golden", "check", lab.golden, "--jobs", "1", *lab.options, *more)


def test_unchanged_results_are_equal(lab, quick):
    result = check(lab)
    assert result.code == 0, result.err
    assert result.out == "equal bit for bit  2\n\nNo change in 2 golden runs\n"
    reference = json.loads((lab.golden / quick.loaded.name / "reference.json").read_text())
    assert reference["found"]["method"] == METHOD
    assert reference["at"] == f"{quick.loaded.name}/run.h5"


def test_changed_compensation_is_reported(lab, quick, tmp_path):
    before = json.loads((lab.golden / quick.loaded.name / "reference.json").read_text())["found"]
    lab.change("raw.value - rig.value + 0.3")
    page, cases = tmp_path / "report.html", tmp_path / "cases.xml"
    result = check(lab, "--html", page, "--junit", cases, "--json")
    assert result.code == 1, result.err
    document = json.loads(result.out)
    assert document["counts"] == {"verdict flipped": 1, "equal bit for bit": 1}
    run = document["runs"][0]
    assert run["verdict"] == {"reference": "pass", "now": "fail"}
    moves = {move["figure"]: move for move in run["moves"]}
    assert set(moves) == {"result", *(f"result at {hz} Hz" for hz in (8, 15, 20, 25, 35))}
    for name, move in moves.items():
        figure = before["figures"][name]
        assert move["now"] - figure["value"] == pytest.approx(0.3)
        assert move["shift_in_u"] == pytest.approx(0.3 / figure["expanded"])
    report = Page()
    report.feed(page.read_text(encoding="utf-8"))
    for text in ("1 of 2 to review", "verdict: pass → fail", "+300.000 mN·m"):
        assert text in report.words
    suite = ET.fromstring(cases.read_text(encoding="utf-8"))  # noqa: S314  (we wrote it)
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert suite.find("testcase/failure").get("message") == "verdict flipped"


def test_shift_within_the_tolerance_passes(lab):
    lab.change("(raw.value - rig.value) * (1 + 1e-12)")
    result = check(lab)
    assert (result.code, "moved within the tolerance  1" in result.out) == (0, True)


def test_refusing_method_and_missing_run_are_reported(lab, quick):
    lab.change("_refuse()")
    result = check(lab)
    assert result.code == 1
    assert f"{quick.loaded.name}: newly refused" in result.out
    (lab.golden / quick.no_load.name / "run.h5").unlink()
    result = check(lab)
    assert result.code == 5
    assert f"{quick.no_load.name}: not compared" in result.out
    assert "there is no " in result.out


def test_damaged_and_exchanged_runs_are_not_compared(lab, quick):
    loaded, no_load = (lab.golden / run.name / "run.h5" for run in (quick.loaded, quick.no_load))
    loaded.chmod(0o644)
    shutil.copyfile(no_load, loaded)
    with no_load.open("r+b") as file:
        file.truncate(no_load.stat().st_size // 2)
    result = check(lab)
    assert (result.code, result.out.count(": not compared")) == (5, 2)
    assert "is another run than the golden one" in result.out


def test_stored_results_are_not_computed_again(lab, tmp_path):
    for before in ("", "2 of 2 runs were done before"):
        result = check(lab, "--out", tmp_path / "kept")
        assert (result.code, before in result.err) == (0, True)


def test_folder_of_the_runs_can_be_given(lab, quick, tmp_path):
    shutil.copytree(quick.loaded.parent, tmp_path / "moved")
    for run in (quick.loaded, quick.no_load):
        (lab.golden / run.name / "run.h5").unlink()
    assert check(lab).code == 5
    assert check(lab, "--runs", tmp_path / "moved").code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["check", "nowhere"], 2, "there is no golden run in nowhere"),
        (["check"], 2, "FOLDER"),
        (["check", "nowhere", "--html", "x.pdf"], 2, "no report is written as 'x.pdf'"),
        (["check", "odd"], 5, "reference.json is not a reference of a golden run: "),
        (["record", "nowhere", "--out", "x"], 2, "there is no nowhere"),
        (["chek", "nowhere"], 2, "Did you mean 'check'?"),
        (["check", "nowhere", "--tolerance", "-1"], 2, "--tolerance"),
    ],
)
def test_invalid_arguments_are_refused(arguments, code, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd").mkdir()
    (tmp_path / "odd/reference.json").write_text('{"format": "rigrunner: golden/2"}')
    result = call("golden", *arguments)
    assert (result.code, "Traceback" in result.err) == (code, False)
    assert message in result.err


def test_golden_runs_are_not_overwritten(lab):
    result = call("golden", "record", lab.golden, "--out", lab.golden, *lab.options)
    assert result.code == 2
    assert "is golden already" in result.err
