"""Six wear blocks at 10 Hz, a final test at 10 Hz, and two dwells: labels tell them apart."""

from __future__ import annotations

import json
import re

import pytest

from helpers_cli import call
from helpers_workflow import quick_procedure, run
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.runfile import read

SIX = """\
rigrunner: procedure/2
id: WEAR-6
revision: "A"
title: Six wear blocks, then the final torque
measurand: {symbol: T, name: torque}
uses: {tester: swing_tester}
main:
  - set: {tester.load: 1000 N, tester.frequency: 10 Hz}
  - repeat:
      times: 6
      as: block
      label: {phase: wear}
      steps:
        - settle: {cycles: 5}
        - record: {channels: [tester.angle, tester.torque], cycles: 12}
  - group:
      label: {phase: final}
      steps:
        - record: {channels: [tester.angle, tester.torque], cycles: 12}
teardown:
  - set: {tester.frequency: 0 Hz, tester.load: 0 N}
analysis:
  - readings:
      of: tester.torque
      statistic: rms
      per: [phase, block]
      where: {phase: wear}
      result: {name: friction, unit: N·m}
  - swing_torque:
      where: {phase: final}
      no_load: {from: latest, procedure: SSPB-NLI}
      compensations: [template_inverse]
acceptance:
  limits:
    - {of: torque, mean: yes, max: 0.95 N·m, source: drawing,
       measurand: {nature: load_induced, condition: at_reversal}}
"""
BENCH = find_station("simulated_bench")
REST = "  - repeat:\n      times: 10\n      steps:\n        - settle: {time: $rest}\n"
RECORD = "        - record: {channels: [tester.angle, tester.torque], duration: 1.5 s}\n"
DWELLS = "".join(
    REST.replace("times: 10", f"times: 6\n      label: {{dwell: {dwell}}}").replace("$rest", dwell)
    + RECORD
    for dwell in ("10 s", "60 s")
)
CHOSEN = "  - breakaway:\n      where: {dwell: 60 s}\n"
GREATEST = """\
  - readings:
      of: tester.torque
      statistic: maximum
      per: dwell
      result: {name: greatest, unit: mN·m}
"""


def written(folder, text, name="wear.yaml"):
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


@pytest.fixture(scope="module")
def six(tmp_path_factory):
    folder = tmp_path_factory.mktemp("six")
    run(quick_procedure(folder, "no_load_inertia_sweep", ("[8 Hz, 15 Hz", "[8 Hz, 10 Hz, 15 Hz")),
        folder / "runs")  # fmt: skip
    run_folder = run(written(folder, SIX), folder / "runs").folder
    return run_folder, json.loads((run_folder / "result.json").read_text(encoding="utf-8"))


def test_only_the_final_test_is_a_point_of_the_torque(six):
    _, document = six
    assert [point["recording"] for point in document["points"]] == ["007_10Hz_final"]
    (part,) = document["decision"]["parts"]
    (torque,) = [result for result in document["results"] if result["name"] == "torque"]
    assert part["result"]["value"] == pytest.approx(torque["estimate"]["value"])


def test_each_block_has_its_own_row(six):
    folder, document = six
    friction = [result for result in document["results"] if result["name"] == "friction"]
    assert [result["coordinates"]["block"]["value"] for result in friction] == [1, 2, 3, 4, 5, 6]
    assert {result["coordinates"]["phase"] for result in friction} == {"wear"}
    assert len({result["estimate"]["value"] for result in friction}) == 6
    names = [recording.name for recording in read(folder).recordings]
    assert names == [*(f"{n:03d}_10Hz_wear_block{n}" for n in range(1, 7)), "007_10Hz_final"]


def test_report_and_show_have_six_wear_rows(six):
    folder, _ = six
    shown = call("show", folder).out
    assert len(re.findall(r"^ *wear +[1-6] ", shown, re.MULTILINE)) == 6
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<th scope="row" class="left">wear</th>', page)) == 6


def test_unselected_recordings_are_refused_rather_than_averaged(tmp_path):
    file = written(tmp_path, SIX.replace("      where: {phase: final}\n", ""))
    called = call("check", file, "--station", find_station("simulated"))
    assert called.code == 3
    assert "recordings with the same set-points would be averaged" in called.err
    assert "phase" in called.err


@pytest.fixture(scope="module")
def dwells(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dwells")
    text = find_procedure("no_load_breakaway").read_text(encoding="utf-8")
    assert REST + RECORD in text
    return text.replace(REST + RECORD, DWELLS), folder


def test_breakaways_after_two_dwells_are_not_pooled(dwells):
    text, folder = dwells
    pooled = call("check", written(folder, text), "--station", BENCH)
    assert pooled.code == 3
    assert "averaged" in pooled.err
    assert "dwell" in pooled.err


def test_each_dwell_is_selected_or_its_own_result(dwells):
    text, folder = dwells
    text = text.replace("  - breakaway:\n", GREATEST + CHOSEN)
    file = written(folder, text, "chosen.yaml")
    run_folder = run(file, folder / "runs", station=BENCH).folder
    document = json.loads((run_folder / "result.json").read_text(encoding="utf-8"))
    greatest = [result for result in document["results"] if result["name"] == "greatest"]
    at = [result["coordinates"]["dwell"] for result in greatest]
    assert at == [{"value": 10.0, "unit": "s"}, {"value": 60.0, "unit": "s"}]
    used = [name for point in document["points"] for name in point.get("recordings", [])]
    used = used or [point["recording"] for point in document["points"]]
    assert all("dwell60s" in name for name in used)
    late = [one.name for one in read(run_folder).recordings if one.coordinates["dwell"] == 60]
    assert len(late) == 6
