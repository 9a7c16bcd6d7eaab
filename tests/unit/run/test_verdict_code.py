"""The exit code of a command that analysed a run."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rigrunner.api.errors import ExitCode
from rigrunner.api.events import Outcome
from rigrunner.api.results import Result
from rigrunner.api.verdict import Decision, LimitDecision, Limits, Verdict
from rigrunner.run.finish import FinishedRun
from rigrunner.run.stored import verdict_code
from unit.analysis.helpers_runs import run_of


def result_with(verdict):
    """Return the result of a completed run with a decision on one limit."""
    part = LimitDecision(
        of="wear",
        verdict=verdict,
        reason="",
        limits=Limits.between(None, 1.0, "mm"),
        source="a test",
    )
    decision = Decision(rule="simple", parts=(part,))
    return Result(run=run_of(), measurand="wear", symbol="w", decision=decision)


@pytest.mark.parametrize(
    ("verdict", "code"),
    [
        (Verdict.PASS, ExitCode.PASS),
        (Verdict.FAIL, ExitCode.FAIL),
        (Verdict.CONDITIONAL_PASS, ExitCode.UNDECIDED),
        (Verdict.INCONCLUSIVE, ExitCode.UNDECIDED),
    ],
)
def test_exit_code_of_completed_run_follows_verdict(verdict, code):
    assert verdict_code(result_with(verdict)) is code


@pytest.mark.parametrize("outcome", ["aborted", "error", ""])
@pytest.mark.parametrize("is_decided", [True, False])
def test_incomplete_run_never_passes(outcome, is_decided):
    result = result_with(Verdict.PASS)
    result = replace(result, run=replace(result.run, outcome=outcome))
    if not is_decided:
        result = replace(result, decision=None)
    assert verdict_code(result) is ExitCode.UNDECIDED


@pytest.mark.parametrize(
    ("verdict", "failed_steps", "code"),
    [
        (Verdict.PASS, (), ExitCode.PASS),
        (Verdict.PASS, ("main[0]: cable",), ExitCode.UNDECIDED),
        (Verdict.FAIL, (), ExitCode.FAIL),
        (Verdict.FAIL, ("main[0]: cable",), ExitCode.FAIL),
    ],
)
def test_failed_step_makes_a_pass_undecided(tmp_path, verdict, failed_steps, code):
    finished = FinishedRun(
        folder=tmp_path,
        outcome=Outcome.COMPLETED,
        reason="",
        error=None,
        result=result_with(verdict),
        passed_over=failed_steps,
    )
    assert finished.exit_code is code
