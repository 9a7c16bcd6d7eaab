"""The table of faults matches the engine: each row is tried on the simulated rig."""

from __future__ import annotations

import re
import threading
from pathlib import Path

import pytest

from e2e.helpers_every_step import FAST, moment_procedure
from helpers_workflow import START, edited
from rigrunner.api.errors import DeviceError
from rigrunner.api.events import Outcome, StepEnded
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.registry import load_registry
from rigrunner.rig import Rig
from rigrunner.run.locate import find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.runfile import read
from rigrunner_plugins.devices.fault.settings import NATURES

PAGE = Path(__file__).parents[2] / "docs/evidence/faults.md"
EXTENTS = {
    "clipped": "0.5 N·m", "spikes": "3 N·m", "drift": "1 N·m", "noise": "0.1 N·m",
    "sensitivity": "2 %", "wrong frequency": "2 %",
}  # fmt: skip
INTERLOCKS = re.compile(r"^  interlocks:\n(    .*\n)+", re.MULTILINE)
RECORD = "tester.torque], cycles: 1}"


def rows_of(title):
    section = PAGE.read_text(encoding="utf-8").split(f"## {title}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in lines[2:]]


ROWS = rows_of("Reactions of the engine")


def planned(folder, kind, call, *, once, terms=""):
    """Plan the short no-load sweep; the fault affects its first set-point, 1 Hz."""
    procedure = moment_procedure(folder, "no_load_inertia_sweep")
    text = procedure.read_text(encoding="utf-8")
    assert RECORD in text
    procedure.write_text(text.replace(RECORD, f"{RECORD[:-1]}{terms}}}"), encoding="utf-8")
    fault = [f"kind: {kind}", f"on: {call}"]
    fault += [f"extent: {EXTENTS[kind]}"] if kind in EXTENTS else []
    fault += ["at: {frequency: 1 Hz}"] if call in {"stream", "read"} else []
    fault += ["channel: load"] if call == "read" else []
    fault += ["drive: frequency"] if call in {"set", "read back"} else []
    fault += ["calls: [1]"] if once and call in {"stream", "read"} else []
    settings = f"{{plugin: swing_tester_sim, settings: {FAST}, faults: [{{{', '.join(fault)}}}]}}"
    station = edited(
        find_station("simulated"),
        folder / "station.yaml",
        plugin=("plugin: swing_tester_sim", "plugin: fault"),
        settings=("{seed: 1}", settings),
    )
    text = INTERLOCKS.sub("", station.read_text(encoding="utf-8"))  # interlocks read too
    station.write_text(text, encoding="utf-8")
    return plan_run(procedure, station, load_registry(), SimulatedClock(START))


def reaction(plan):
    """Run, and return the name of the error and the outcome in the words of the table."""
    rig, log = Rig(plan.devices, plan.clock), []
    try:
        rig.connect()
    except DeviceError as error:
        return type(error).__name__, "not begun"
    summary = run_plan(
        plan.plan, rig, Bus([log.append]), plan.clock, UnattendedAnswers(), threading.Event(), "r"
    )
    rig.close()
    good = {e.recording for e in log if isinstance(e, StepEnded) and e.ok}
    if summary.outcome is Outcome.COMPLETED:
        is_lost = "001_1Hz" not in good and "001_1Hz_try2" not in good
        assert bool(summary.passed_over) is is_lost
        return "none", "point lost" if is_lost else "completed"
    assert summary.outcome is Outcome.ERROR
    safe = "safe" if summary.safe else "not safe"
    return type(summary.error).__name__, f"run ends, {safe}"


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]} in {row[1]}")
def test_engine_reacts_as_the_table_states(row, tmp_path):
    kind, call, error, alone, with_retries, continuing = row
    assert reaction(planned(tmp_path, kind, call, once=True)) == (error, alone)
    if with_retries != "-":
        retried = planned(tmp_path, kind, call, once=True, terms=", retries: 1")
        assert reaction(retried)[1] == with_retries
        continued = planned(tmp_path, kind, call, once=False, terms=", on_fail: continue")
        assert reaction(continued)[1] == continuing


def test_the_table_has_every_kind_of_fault():
    assert {row[0] for row in ROWS} == set(NATURES)
    page = PAGE.parents[1] / "reference/faults.md"
    kinds = page.read_text(encoding="utf-8").split("| kind |")[1].split("\n\n")[0]
    assert [line.split("`")[1] for line in kinds.splitlines()[2:]] == list(NATURES)


def test_failed_attempt_is_incomplete_and_the_next_one_counts(tmp_path):
    plan = planned(tmp_path, "gap", "stream", once=True, terms=", retries: 1")
    finished = execute(
        plan, runs=tmp_path / "runs", inputs={}, partners={}, answers=UnattendedAnswers(),
        stop=threading.Event(), listeners=(),
    )  # fmt: skip
    stored = read(finished.folder)
    names = [recording.name for recording in stored.recordings]
    assert names[0] == "001_1Hz_try2"
    assert "001_1Hz" not in names
