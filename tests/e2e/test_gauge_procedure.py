"""The shipped gauge study, from its sessions on the simulated rig to the report."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from e2e.helpers_trends import index_all
from helpers_cli import call
from helpers_workflow import START, edited, quick_procedure, run, station_file
from rigrunner.clock import SimulatedClock
from rigrunner.run.locate import find_procedure

pytestmark = pytest.mark.thorough

TORQUES_NM = {"SN-1": 0.68, "SN-2": 0.7262, "SN-3": 0.78}
SHIFTS_NM = {"A. Turner": 0.0, "B. Meyer": 0.012}
"""The effect of the second person's mounting, which the simulated bearing does not have."""
ONLY_10_HZ = "[8 Hz, 10 Hz, 20 Hz, 30 Hz]"


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A no-load run and six sessions, each with another seed."""
    folder = tmp_path_factory.mktemp("gauge")
    clock, runs = SimulatedClock(START), folder / "runs"
    sweep = quick_procedure(
        folder, "no_load_inertia_sweep", ("[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]", ONLY_10_HZ)
    )
    run(sweep, runs, clock=clock)
    procedure = edited(
        find_procedure("gauge_rr"), folder / "gauge_rr.yaml", one=("cycles: 30}", "cycles: 12}")
    )
    seed = 1
    for operator, shift in SHIFTS_NM.items():
        for part, torque in TORQUES_NM.items():
            seed += 1
            bearing = f"{{seed: {seed}, bearing: {{starting_torque: {torque + shift:.4f} N·m}}}}"
            station = station_file(folder, ("{seed: 1}", bearing))
            run(
                procedure,
                runs,
                station=station,
                clock=clock,
                given={"specimen": part, "operator": operator},
            )
    index_all(runs)
    return runs


def test_sessions_give_a_study(study, tmp_path):
    report = tmp_path / "gauge.html"
    done = call("gauge-rr", "--procedure", "SSPB-GRR", "--runs", study, "--json", "--out", report)
    assert done.code == 0, done.err
    report_data = json.loads(done.out)
    assert report_data["parts"] == list(TORQUES_NM)
    assert report_data["operators"] == list(SHIFTS_NM)
    readings = np.array(report_data["readings"])
    assert readings.shape == (3, 2, 3)
    true = np.add.outer(list(TORQUES_NM.values()), list(SHIFTS_NM.values()))
    # one of six means may exceed U: these rigs have no growth of friction under load
    assert readings.mean(axis=2) == pytest.approx(true, abs=1.5 * report_data["expanded"])
    components = report_data["analysis"]["components"]
    # two operators 12 mN·m apart and three parts: deviations estimated from so few
    assert components["operator"] == pytest.approx(0.012 / 2**0.5, rel=0.2)
    assert components["part"] == pytest.approx(np.std(list(TORQUES_NM.values()), ddof=1), rel=0.1)
    assert components["repeatability"] < 0.004
    page = report.read_text(encoding="utf-8")
    assert re.search(r"3 parts . 2 operators . 3 trials", page)
    assert "B. Meyer" in page


def test_study_enters_u_of_the_next_result(study, tmp_path):
    """The printed lines go into the station; two operators leave one degree of freedom."""
    printed = call("gauge-rr", "--procedure", "SSPB-GRR", "--runs", study)
    study_data = json.loads(
        call("gauge-rr", "--procedure", "SSPB-GRR", "--runs", study, "--json").out
    )
    lines = re.search(r"^  gauge_study:\n(?:    .*\n)+", printed.out, re.MULTILINE)[0]
    station = station_file(tmp_path, ("  inertia: 0.00233", f"{lines}  inertia: 0.00233"))
    sweep = quick_procedure(tmp_path, "no_load_inertia_sweep")
    run(sweep, tmp_path / "runs")
    loaded = quick_procedure(tmp_path, "starting_torque_1000n")
    results = {
        name: run(loaded, tmp_path / "runs", station=station_file_path).result
        for name, station_file_path in (("plain", None), ("named", station))
    }
    components = study_data["analysis"]["components"]
    reproducibility = np.hypot(components["operator"], components["interaction"])
    budget = {component.name: component for component in results["named"].means[0].components}
    source = "(SSPB-GRR, 3 parts, 2 operators, 3 trials)"
    by_persons = budget[f"reproducibility {source}"]
    assert by_persons.u == pytest.approx(reproducibility, rel=0.01)
    assert 1.0 <= by_persons.dof < 1.5
    mounting = budget[f"scatter between mountings {source}"]
    assert mounting.u == pytest.approx(components["repeatability"], rel=0.01)
    without_study = results["plain"].headline.u
    expected = np.sqrt(without_study**2 + by_persons.u**2 + mounting.u**2)
    assert results["named"].headline.u == pytest.approx(expected, rel=1e-3)


def test_procedure_asks_for_mounting_before_each_trial(study):
    (session, *_) = (
        study / name for name in sorted(p.name for p in study.iterdir()) if "GRR" in name
    )
    log = (session / "run.log").read_text(encoding="utf-8")
    assert log.count("Take the bearing off") >= 3
