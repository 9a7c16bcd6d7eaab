"""Points recorded by hand: the procedure keeps its analysis, but no steps and limits."""

from __future__ import annotations

import threading

import pytest

from rigrunner.api.errors import ExitCode
from rigrunner.api.events import Outcome
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.prepare import plan_run
from rigrunner.tools.by_hand.points import by_hand, record_by_hand
from unit.engine.helpers_pausing import Person


@pytest.mark.parametrize("name", ["starting_torque_1000n", "no_load_inertia_sweep"])
def test_manual_procedure_keeps_measurand_and_analysis_as_a_draft(name):
    planned = plan_run(
        find_procedure(name), find_station("simulated"), load_registry(), SimulatedClock()
    )
    manual = by_hand(planned)
    model, original = manual.procedure.model, planned.procedure.model
    assert model.analysis == original.analysis
    assert model.measurand == original.measurand
    assert model.acceptance is None
    assert model.id == f"{original.id}-by-hand"
    assert original.id in manual.procedure.text
    assert manual.plan.steps == ()
    assert manual.plan.interlocks == planned.plan.interlocks
    assert manual.approval.is_draft
    assert not manual.procedure.inputs


def test_session_without_points_is_completed_without_a_result(tmp_path):
    planned = plan_run(
        find_procedure("no_load_inertia_sweep"), find_station("simulated"), load_registry(),
        SimulatedClock(),
    )  # fmt: skip
    run = record_by_hand(
        planned, lambda _session: iter(()), runs=tmp_path, partners={}, stop=threading.Event(),
        pauses=Person([]),
    )  # fmt: skip
    assert (run.outcome, run.error, run.result) == (Outcome.COMPLETED, None, None)
    assert run.exit_code is ExitCode.PASS
    assert (run.folder / "run.h5").exists()
