"""Procedures without an angle channel, and their terminal output, report and JSON."""

from __future__ import annotations

import json

import pytest

from helpers_workflow import quick_procedure, run
from rigrunner.cli.summary import summary
from rigrunner.registry import load_registry
from rigrunner.run.stored import analyse_run

pytestmark = pytest.mark.thorough

ANGLE = "channels: [tester.angle, tester.torque]"
PEAKS = (
    "        - template_inverse\n",
    "        - peak_same_frequency\n        - template_inverse\n",
)


BY_PEAKS = ("primary: template_inverse", "primary: peak_same_frequency")
"""A procedure whose primary method needs an angle is refused where none is recorded."""


def procedures(folder, channels, *changes):
    recorded = (ANGLE, f"channels: {channels}")
    return (
        quick_procedure(folder, "no_load_inertia_sweep", recorded),
        quick_procedure(folder, "starting_torque_1000n", recorded, PEAKS, *changes),
    )


def finished(folder, channels, *changes):
    no_load, loaded = procedures(folder, channels, *changes)
    no_load_run = run(no_load, folder / "runs")
    assert no_load_run.error is None
    done = run(loaded, folder / "runs", no_load=no_load_run.folder)
    assert done.error is None
    return done


def texts(done):
    content = json.loads((done.folder / "result.json").read_text(encoding="utf-8"))
    report = (done.folder / "report.html").read_text(encoding="utf-8")
    return content, report, summary(content)


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    return finished(tmp_path_factory.mktemp("bare"), "[tester.torque]", BY_PEAKS)


@pytest.fixture(scope="module")
def indexed(tmp_path_factory):
    return finished(tmp_path_factory.mktemp("indexed"), "[tester.index, tester.torque]")


def test_without_angle_all_outputs_say_what_is_not_applicable(bare):
    content, report, terminal = texts(bare)
    reason = "comparing whole swings needs an angle channel"
    for method in ("template_inverse", "energy"):
        assert reason in content["compensations"][method]["not_applicable"]
        assert f"{method}: not applicable: {reason}" in terminal
        assert f"<strong>{method}</strong> is not applicable to this run: {reason}" in report
    for method in ("paper_peak", "peak_same_frequency"):
        assert len(content["compensations"][method]["points"]) == 5
    for text in (json.dumps(content), report, terminal):
        assert "cycles were cut by the entered frequency, and only peak methods apply" in text
    assert content["headline"]["method"] == "peak_same_frequency"


def test_without_angle_the_report_shows_neither_swing_nor_motion(bare):
    _, report, _ = texts(bare)
    assert 'id="swing"' not in report
    assert 'href="#swing"' not in report
    assert 'id="motion"' not in report
    assert 'id="cycles"' in report


def test_with_an_index_every_method_applies_with_its_uncertainty(indexed):
    content, report, terminal = texts(indexed)
    assert all(compensation["points"] for compensation in content["compensations"].values())
    budget = content["compensations"]["template_inverse"]["points"][-1]["budget"]
    names = {component["name"] for component in budget}
    assert {"place of the index or tacho", "time of the index pulse"} <= names
    for text in (json.dumps(content), report, terminal):
        assert "from one index pulse per cycle, with a larger uncertainty" in text
    assert content["headline"]["compensated"]["value"] == pytest.approx(0.7262, abs=0.02)


@pytest.mark.parametrize("name", ["bare", "indexed"])
def test_reanalysis_gives_the_same_result(name, request):
    done = request.getfixturevalue(name)
    reanalysed = analyse_run(done.folder, load_registry())
    assert reanalysed.headline == done.result.headline
    assert [check.text for check in reanalysed.checks] == [
        check.text for check in done.result.checks
    ]
