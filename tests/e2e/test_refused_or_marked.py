"""What must never give a number in silence: each is refused or marked, in exactly these words."""

from __future__ import annotations

import shutil
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from helpers_cli import call
from helpers_workflow import edited, station_file
from rigrunner.api.data import Measurement
from rigrunner.api.errors import DataError, ExitCode
from rigrunner.api.verdict import Verdict
from rigrunner.certificate.results import results_of
from rigrunner.run.locate import find_procedure
from rigrunner_bearings.torque.settings import SwingTorque
from unit.analysis.helpers_analysis import LOADED_SPEC, acceptance, analysed, recording, run_of

TODAY = datetime.now(UTC).date()
SHIPPED = "starting_torque_1000n"
THIS_RUN = SwingTorque.model_validate(
    LOADED_SPEC
    | {
        "no_load": {"from": "this run"},
        "compensations": ["peak_same_frequency"],
        "primary": "peak_same_frequency",
    }
)
FREQUENCIES = (2.0, 4.0, 6.0, 8.0)
SCATTER_NM = (0.01, -0.01, 0.0, 0.02, -0.02, 0.0)


@pytest.fixture
def procedure(tmp_path):
    return shutil.copy(find_procedure(SHIPPED), tmp_path / "procedure.yaml")


def sweep(torque_nm, **changes):
    """Return a run of a rig that shows 1 N·m in addition to the torque."""
    load_n = 1000.0 if torque_nm else 0.0
    return run_of(
        *(
            recording([1 + torque_nm + scatter_nm for scatter_nm in SCATTER_NM], hz, load_n=load_n)
            for hz in FREQUENCIES
        ),
        **changes,
    )


def single_values():
    """Return a run of single values: 1 N·m without load, and 0.5 N·m more under 1000 N."""
    units = {"tester.frequency": "Hz", "tester.load": "N", "tester.torque": "N·m"}
    rows = [
        Measurement(
            *("table", "2026-01-01T12:00:00+00:00"),
            {"tester.load": load_n, "tester.frequency": hz},
            {"tester.torque": torque_nm},
            units,
        )
        for load_n, torque_nm in ((0.0, 1.0), (1000.0, 1.5))
        for hz in (2.0, 8.0)
    ]
    return replace(run_of(), measurements=tuple(rows))


def test_overdue_calibration_is_refused(procedure, tmp_path):
    due = TODAY - timedelta(days=1)
    entry = f"    certificate: K-1\n    due: {due} #"
    station = station_file(tmp_path, ("    calibration: simulated ", entry))
    refused = call("check", procedure, "--station", station)
    assert refused.code == ExitCode.INVALID
    assert refused.err == (
        f"{station}:34:10: error: instruments[0].due: the calibration of SIM-TQ-01"
        f" (tester.torque) was due on {due}, 1 day before this run\n"
        "  hint: have it calibrated and enter the new certificate;"
        " or start with --override SIM-TQ-01 --by NAME --reason TEXT\n"
    )


def test_approval_of_an_edited_procedure_is_void(procedure):
    assert call("approve", procedure, "--by", "A. Jones").code == ExitCode.PASS
    edited(procedure, procedure, limit=("max: 0.95 N·m", "max: 0.96 N·m"))
    assert call("approve", procedure, "--show").out == (
        "SSPB-STT-1000, revision A: draft, not for certification:"
        f" the procedure was changed after its approval by A. Jones on {TODAY}\n"
    )


def test_limit_of_another_measurand_is_refused(tmp_path):
    other = edited(
        find_procedure(SHIPPED),
        tmp_path / "procedure.yaml",
        measurand=(
            "nature: load_induced, condition: at_reversal, load: 1000 N",
            "nature: no_load, condition: from_rest",
        ),
    )
    refused = call("check", other, "--station", "simulated")
    assert refused.code == ExitCode.INVALID
    assert refused.err == (
        f"{other}:66:18: error: acceptance.limits[0].measurand: the limit is for the no-load torque"
        " from rest, and the result is the load-induced torque at the reversals of a swing\n"
        "  hint: a limit applies only to results of the same measurand\n"
    )


def test_missing_low_pass_is_refused(procedure, tmp_path):
    line = "    low_pass: {type: butterworth, order: 2, corner: 1 kHz}"
    station = station_file(tmp_path, (line, ""))
    refused = call("check", procedure, "--station", station)
    assert refused.code == ExitCode.INVALID
    assert refused.err == (
        f"{station}:29:5: error: instruments[0]: the low_pass of the instrument for"
        " tester.torque is missing\n"
        "  hint: the filter shapes the torque at the reversals; it is needed at"
        f" {procedure}:40:19\n"
    )


def test_negative_torque_is_inconclusive():
    result = analysed(sweep(-0.25), sweep(0.0, run_id="run-0"), accept=acceptance())
    where = "; ".join(f"{hz:g} Hz -0.2500 N·m" for hz in FREQUENCIES)
    (check,) = [check for check in result.checks if check.name == "positive torque"]
    assert (check.ok, check.text) == (False, where)
    assert check.advice == (
        "friction cannot drive: the no-load run or the method does not fit this run"
    )
    assert result.decision.verdict is Verdict.INCONCLUSIVE
    assert result.decision.reason.startswith(f"The check 'positive torque' failed: {where};")
    assert result.decision.reason.endswith(f"; no verdict ({check.advice}).")


def test_missing_uncertainty_is_inconclusive_and_not_certified():
    result = analysed(single_values(), analysis_spec=THIS_RUN, accept=acceptance())
    assert result.decision.verdict is Verdict.INCONCLUSIVE
    assert result.decision.reason == (
        "A single value shows no scatter (at 2 Hz, 8 Hz): the uncertainty lacks its type A part,"
        " and no probability can be stated."
    )
    with pytest.raises(DataError) as refused:
        results_of(result)
    assert refused.value.message == (
        "the result has no uncertainty, and cannot be on a certificate"
    )
