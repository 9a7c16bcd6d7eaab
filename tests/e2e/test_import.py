"""Recordings in every format give the same result as the original run."""

from __future__ import annotations

import json

import pytest

from e2e.helpers_numbers import numbers
from helpers_certificate import issue, make_letterhead
from helpers_cli import call
from unit.rigrunner_plugins.importers.helpers_importing import OPERATOR, SPECIMEN, WRITERS, export

pytestmark = pytest.mark.thorough


def results(run):
    return json.loads((run / "result.json").read_text(encoding="utf-8"))


def assert_same(original, imported, *, exact):
    expected, imported_numbers = numbers(results(original)), numbers(results(imported))
    assert len(expected) > 100
    assert imported_numbers == (expected if exact else pytest.approx(expected, rel=1e-6, abs=1e-6))


def procedure(runs, name):
    """Return the file of the procedure that a run followed."""
    return runs.folder.parent / f"{name}.yaml"


@pytest.mark.parametrize("kind", WRITERS)
def test_imported_run_has_the_same_result(quick, tmp_path, kind):
    loaded = export(quick.loaded, tmp_path / "l", kind, procedure(quick, "starting_torque_1000n"))
    runs = tmp_path / "runs"
    called = call("import", loaded, "--runs", runs, "--no-load", quick.no_load)
    assert called.code == 0, called.err
    (imported,) = runs.iterdir()
    assert_same(quick.loaded, imported, exact=kind != "csv")  # CSV in mN·m rounds


def test_imported_no_load_run_is_used(quick, tmp_path):
    runs = tmp_path / "runs"
    for name, run, of, inputs in (
        ("n", quick.no_load, "no_load_inertia_sweep", OPERATOR),
        ("l", quick.loaded, "starting_torque_1000n", SPECIMEN),
    ):
        mapping = export(run, tmp_path / name, "tdms", procedure(quick, of), inputs=inputs)
        called = call("import", mapping, "--runs", runs)
        assert called.code == 0, called.err
    no_load, loaded = sorted(runs.iterdir())
    assert_same(quick.no_load, no_load, exact=True)
    assert_same(quick.loaded, loaded, exact=True)
    report = (loaded / "report.html").read_text(encoding="utf-8")
    assert "made the recordings of this run and of the no-load run, not Rigrunner" in report
    letterhead = make_letterhead(tmp_path / "letterhead")
    issued = issue(loaded, letterhead, loaded)
    (content,) = (path for path in issued.files if path.suffix == ".json")
    document = json.loads(content.read_text(encoding="utf-8"))
    deviations = [(deviation["run_id"], deviation["text"]) for deviation in document["deviations"]]
    for run in (no_load, loaded):
        assert any(of == run.name and "SwingTest.vi 3.2 made" in text for of, text in deviations)
    simulated = {restriction["code"] for restriction in document["restrictions"]}
    assert "simulated" in simulated  # as the station that it was recorded on
    assert call("verify", content, "--letterhead", letterhead).code == 0
