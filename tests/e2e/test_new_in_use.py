"""A drop-in plugin of each kind that `rigrunner new` creates works in real runs as it is."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest

from helpers_cli import call
from helpers_workflow import quick_procedure, station_file
from rigrunner.api.errors import ExitCode
from rigrunner.registry import load_registry
from rigrunner.runfile import read
from rigrunner.tools.new_plugin import KINDS, new_plugin

NAMES = {word: f"own_{word.replace('-', '_')}" for word in (*KINDS, "compensation")}
HERTZ = (8, 15, 20, 25, 35)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Return a lab's folder whose analyses use new plugins only, and its two runs."""
    folder = tmp_path_factory.mktemp("lab")
    (folder / "plugins").mkdir()
    for word, name in NAMES.items():
        text = new_plugin(word, name, load_registry()).module()
        (folder / "plugins" / f"{name}.py").write_text(text, encoding="utf-8")
    station = station_file(folder, ("id: simulated\n", "id: simulated\nplugins: plugins\n"))
    rule = ("{grubbs: {alpha: 0.05}}", f"{{{NAMES['outlier-rule']}: {{limit: 6}}}}")
    fit = ("        - polynomial: {degree: 2}\n", f"        - {NAMES['fit']}\n")
    method = (
        "        - template_inverse\n",
        f"        - template_inverse\n        - {NAMES['compensation']}\n",
    )
    no_load = quick_procedure(folder, "no_load_inertia_sweep", rule, fit)
    limit = ("rule: guard_band_u", f"rule: {{{NAMES['rule']}: {{share: 0.5}}}}")
    loaded = quick_procedure(folder, "starting_torque_1000n", rule, fit, method, limit)
    for procedure in (no_load, loaded):
        words = ["--station", station, "--unattended", "--runs", folder / "runs"]
        called = call("run", procedure, *words)
        assert called.code in {ExitCode.PASS, ExitCode.FAIL, ExitCode.UNDECIDED}, called.err
    return folder, sorted((folder / "runs").iterdir())


def result_of(run):
    return json.loads((run / "result.json").read_text(encoding="utf-8"))


def test_new_outlier_rule_and_fit_are_in_the_result(lab):
    _, (no_load, _) = lab
    result = result_of(no_load)
    assert NAMES["outlier-rule"] in json.dumps(result["analysis"])
    fits = {fit["name"]: fit for fit in result["fits"]}
    assert fits[NAMES["fit"]]["curve"]["formula"] == "y = c0 + c1*x"


def test_new_decision_rule_decides(lab):
    _, (_, loaded) = lab
    result = result_of(loaded)
    decision = result["decision"]
    assert decision["rule"].startswith(f"{NAMES['rule']}: guard band w = 0.5 U")
    half = result["headline"]["compensated"]["expanded_uncertainty_95"] / 2
    assert decision["guard_band"]["value"] == pytest.approx(half)
    assert result["revisions"][f"decision_rule {NAMES['rule']}"] == 1


def test_new_compensation_is_listed_with_the_others(lab):
    _, (_, loaded) = lab
    compensations = result_of(loaded)["compensations"]
    assert set(compensations) == {"paper_peak", "template_inverse", "energy", NAMES["compensation"]}
    torques = [point["torque"]["value"] for point in compensations[NAMES["compensation"]]["points"]]
    assert len(torques) == len(HERTZ)
    assert all(0.2 < torque < 2.5 for torque in torques)


def test_new_report_has_a_row_for_each_result(lab):
    folder, (_, loaded) = lab
    words = ["--station", folder / "station.yaml", "--runs", folder / "runs"]
    called = call("report", loaded.name, *words, "--format", NAMES["report"])
    assert called.code == ExitCode.PASS, called.err
    written = loaded / "report.csv"
    assert called.out.strip() == str(written)
    head, *rows = csv.reader(io.StringIO(written.read_text(encoding="utf-8")))
    assert head == ["result", "place", "value", "standard uncertainty", "unit"]
    assert [row[0] for row in rows] == ["torque"] * len(HERTZ)
    result = result_of(loaded)
    primary = result["compensations"][result["analysis"]["primary"]]["points"]
    values = [float(row[2]) for row in rows]
    assert sorted(values) == pytest.approx(sorted(p["torque"]["value"] for p in primary))


def test_new_importer_makes_the_same_run_from_text_files(lab):
    folder, (no_load, _) = lab
    for recording, hertz in zip(read(no_load).recordings, HERTZ, strict=True):
        columns = np.c_[recording.channels["tester.angle"], recording.channels["tester.torque"]]
        np.savetxt(
            folder / f"{hertz}.txt", columns, fmt="%.17g", header="angle torque", comments=""
        )
    zero = read(no_load).zeros["tester.torque"]
    recordings = "\n".join(
        f"  - {{file: {hertz}.txt, set_points: {{tester.frequency: {hertz} Hz}}}}"
        for hertz in HERTZ
    )
    mapping = folder / "mapping.yaml"
    mapping.write_text(
        "rigrunner: import/1\n"
        "procedure: no_load_inertia_sweep.yaml\n"
        "station: station.yaml\n"
        f"format: {NAMES['importer']}\n"
        "program: a program of our own\n"
        "by: A. Jones\n"
        "started: 2026-03-02T09:15:00+01:00\n"
        "inputs: {operator: B. Lee}\n"
        "sampling: {rate: 10 kHz}\n"
        "channels:\n"
        "  tester.angle: {column: angle, unit: rad}\n"
        "  tester.torque: {column: 2, unit: N·m}\n"
        f"zeros: {{tester.torque: {zero!r} N·m}}\n"
        "set_points: {tester.load: 0 N}\n"
        f"recordings:\n{recordings}\n",
        encoding="utf-8",
    )
    called = call(
        "import", mapping, "--runs", folder / "imported", "--station", folder / "station.yaml"
    )
    assert called.code == ExitCode.PASS, called.err
    (imported,) = (folder / "imported").iterdir()
    expected, imported_slope = (slope_of(result_of(run)) for run in (no_load, imported))
    assert imported_slope == pytest.approx(expected, rel=1e-9)


def slope_of(result):
    return result["fits"][0]["curve"]["coefficients"]["c1"]["value"]


def test_station_offers_the_new_device(lab):
    folder, _ = lab
    called = call("plugins", NAMES["device"], "--station", folder / "station.yaml")
    assert called.code == ExitCode.PASS
    assert "simulated: no" in called.out or "simulated: false" in called.out
