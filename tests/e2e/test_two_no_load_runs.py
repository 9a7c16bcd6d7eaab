"""A no-load run before and one after: the loaded run waits for it, and drift is removed."""

from __future__ import annotations

import json
from datetime import timedelta

import numpy as np
import pytest

from helpers_certificate import make_letterhead
from helpers_cli import call
from helpers_workflow import START, quick_procedure, run, station_file
from rigrunner.api.errors import ExitCode
from rigrunner.clock import SimulatedClock
from rigrunner.runfile import read
from rigrunner_panel.history import History

TRUE_NM = 0.7262
"""The simulated bearing's starting torque under 1000 N."""
COLDER = 1.06
"""The support's friction after the loaded run, relative to before it; halfway in between."""
COULOMB_NM = 0.7597
PLAIN, AFTER = "max_age: 8 h, ", "max_age: 8 h, after: true, "
NAMED = "drift between the no-load points (time)"


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Three runs two hours apart on a rig that gets colder; the loaded one waits."""
    folder = tmp_path_factory.mktemp("bracket")
    runs, procedures = folder / "runs", {}
    procedures["no-load"] = quick_procedure(folder, "no_load_inertia_sweep")
    procedures["loaded"] = quick_procedure(folder, "starting_torque_1000n", (PLAIN, AFTER))
    finished = {}
    for number, name in enumerate(("before", "loaded", "after")):
        place = folder / name
        place.mkdir()
        torque = COULOMB_NM * (1 + (COLDER - 1) * number / 2)
        rig = f"{{seed: 1, support: {{friction: {torque:.5f} N·m}}}}"
        station = station_file(place, ("{seed: 1}", rig))
        procedure = procedures["loaded" if name == "loaded" else "no-load"]
        clock = SimulatedClock(START + timedelta(hours=2 * number))
        finished[name] = run(procedure, runs, station=station, clock=clock)
    return finished


def test_loaded_run_waits_and_its_state_says_so(lab):
    loaded = lab["loaded"]
    assert loaded.waits
    assert loaded.exit_code is ExitCode.UNDECIDED
    assert loaded.result is None
    assert (loaded.folder / "journal").is_dir()
    listed = call("runs", "--runs", loaded.folder.parent)
    (line,) = (each for each in listed.out.splitlines() if loaded.folder.name in each)
    assert "completed, waits for a run after it" in line
    states = {item.run: item.state for item in History(loaded.folder.parent).items()}
    assert states[loaded.folder.name] == "completed, waits for a run after it"


@pytest.mark.thorough
def test_resume_uses_the_second_run_and_removes_the_drift(lab):
    name, runs = lab["loaded"].folder.name, lab["loaded"].folder.parent
    resumed = call("resume", name, "--runs", runs, "--no-load-after", lab["before"].folder.name)
    assert resumed.code != 0
    assert "before this run, and the second one has to come after it" in resumed.err
    resumed = call("resume", name, "--runs", runs)
    assert resumed.code in {ExitCode.PASS, ExitCode.FAIL, ExitCode.UNDECIDED}, resumed.err
    stored = read(lab["loaded"].folder)
    assert stored.info.sealed
    assert stored.partners["no_load"].header.run_id == lab["before"].folder.name
    assert stored.partners["no_load_after"].header.run_id == lab["after"].folder.name
    result = json.loads((lab["loaded"].folder / "result.json").read_text(encoding="utf-8"))
    assert result["no_load_run_after"]["id"] == lab["after"].folder.name
    mean = result["headline"]["compensated"]
    assert abs(mean["value"] - TRUE_NM) < mean["expanded_uncertainty_95"]
    (drift,) = (line for line in result["headline"]["budget"] if line["name"] == NAMED)
    assert drift["contribution"]["value"] == pytest.approx(
        0.5 * (COLDER - 1) * COULOMB_NM * 0.82 / np.sqrt(3), rel=0.25
    )
    assert call("verify", lab["loaded"].folder).code == 0
    shown = call("show", name, "--runs", runs)
    assert lab["after"].folder.name in shown.out
    lab_folder = make_letterhead(runs.parent / "letterhead")
    called = call(
        "certify", name, "--runs", runs, "--authorised-by", "A", "--customer", "Muster",
        "--customer-contact", "x", "--item", "bearing", "--item-condition", "new",
        "--received", "2026-02-27", "--letterhead", lab_folder, "--out", runs.parent / "out",
        "--not-for-certification",
    )  # fmt: skip
    assert called.code == 0, called.err
    (content,) = (runs.parent / "out").glob("*.json")
    evidence = json.loads(content.read_text(encoding="utf-8"))["evidence"]
    assert evidence["no_load_run"]["run_id"] == lab["before"].folder.name
    assert evidence["no_load_run_after"]["run_id"] == lab["after"].folder.name
    (page,) = (runs.parent / "out").glob("*.html")
    assert page.read_text(encoding="utf-8").count(lab["after"].folder.name) >= 2
    reanalysed = call("analyse", name, "--runs", runs, "--json")
    assert json.loads(reanalysed.out)["headline"]["compensated"] == mean
