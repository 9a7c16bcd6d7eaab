# ruff: noqa: RUF001  (typographic signs are expected)
from __future__ import annotations

from dataclasses import replace
from datetime import date
from math import inf, nan

import pytest

from rigrunner.api.checks import skipped
from rigrunner.api.data import Estimate, Measurement
from rigrunner.api.instruments import Instrument
from rigrunner.api.verdict import Verdict
from rigrunner_bearings.report.view.budget import degrees_of_freedom
from rigrunner_reports.view import run
from rigrunner_reports.view.checks import check_rows
from rigrunner_reports.view.decision import DecisionView
from rigrunner_reports.view.instruments import instruments
from rigrunner_reports.view.limits import measured_table
from unit.rigrunner_reports.helpers_report import (
    INSTRUMENT,
    deciding,
    loaded_result,
)


@pytest.fixture(scope="module")
def result():
    return loaded_result()


def test_degrees_of_freedom_are_rounded_down():
    assert [degrees_of_freedom(dof) for dof in (14.99, 1e5, inf)] == ["14", "∞", "∞"]


def test_failed_checks_come_first_with_their_method(result):
    rows = check_rows(result)
    assert [row.ok for row in rows] == [False, False, True, True]
    assert [(row.name, row.source) for row in rows[:2]] == [
        ("cycles", ""),
        ("resonance", "template_inverse"),
    ]


def test_skipped_check_does_not_count_as_passed(result):
    rows = check_rows(replace(result, checks=(*result.checks, skipped("load", "no load is known"))))
    assert [row.name for row in rows if not row.was_made] == ["load"]
    assert [row.ok for row in rows] == [False, False, True, True, True]
    assert rows[2].name == "load", "after failed checks, before passed ones"


@pytest.mark.parametrize(
    ("probability", "text"),
    [(1.0, "> 99.99 %"), (0.975, "97.50 %"), (1e-6, "< 0.01 %"), (nan, "not determined")],
)
def test_probabilities_are_not_shown_as_certain(result, probability, text):
    decision = deciding(result.decision, probability=probability)
    assert DecisionView(decision, complete=True).deciding.probability == text


@pytest.mark.parametrize("verdict", Verdict)
def test_every_verdict_has_symbol_and_word(result, verdict):
    shown = DecisionView(deciding(result.decision, verdict=verdict), complete=True).verdict
    assert shown.symbol
    assert shown.word == str(verdict)


def test_stopped_run_has_no_verdict_but_shows_outcome_of_rule(result):
    shown = DecisionView(result.decision, complete=False)
    assert shown.verdict.word == "no verdict"
    assert "the rule would say: pass" in shown.reason


def test_overdue_instrument_is_marked(result):
    late = INSTRUMENT.model_copy(update={"due": date(2026, 3, 1)})
    on_the_day = INSTRUMENT.model_copy(update={"due": date(2026, 3, 2)})
    unzeroed = replace(result.run, instruments={"a": late, "b": on_the_day}, zeros={})
    rows = [dict(facts) for facts in instruments(unzeroed)]
    assert [row["Calibration due"] for row in rows] == [
        "2026-03-01, OVERDUE at this run",
        "2026-03-02",
    ]
    assert [row["Zero taken off"] for row in rows] == ["not zeroed", "not zeroed"]


def test_resolution_is_shown_as_the_step_that_it_is(result):
    gauge = Instrument.model_validate(
        {
            "channel": "bench.gauge",
            "measures": "pressure",
            "serial": "PG-1",
            "accuracy": {"resolution": "10 mbar", "creep": "5 mbar"},
        }
    )
    run = replace(result.run, instruments={"bench.gauge": gauge}, zeros={})
    (row,) = map(dict, instruments(run))
    assert row["Resolution"] == "10 mbar, rectangular"
    assert row["Creep"] == "±5 mbar, rectangular"


def test_accuracy_limits_are_shown_in_their_units(result):
    (row,) = map(dict, instruments(result.run))
    assert row["Accuracy"] == (
        "gain ±0.3 %, offset ±0.02 N·m, drift ±0.02 N·m, non-linearity ±0.05 % of full scale"
    )
    assert row["Low-pass filter"] == "Butterworth, order 2, 1000 Hz"
    assert row["Zero taken off"] == "+0.0123 N·m"


def test_resolution_is_a_step_without_sign_and_small_gain_is_as_written(result):
    accuracy = {"gain": "0.1 ppm", "resolution": "0.01 V", "hysteresis": "0.02 V"}
    meter = {"channel": "m.v", "measures": "voltage", "serial": "1", "accuracy": accuracy}
    run = replace(result.run, instruments={"m.v": Instrument.model_validate(meter)})
    (row,) = map(dict, instruments(run))
    assert row["Accuracy"] == "gain ±0.1 ppm"
    assert row["Resolution"] == "0.01 V, rectangular"
    assert row["Hysteresis"] == "±0.02 V, rectangular"


def test_zeroed_force_is_in_newtons(result):
    cell = Instrument.model_validate({"channel": "press.force", "measures": "force", "serial": "1"})
    run = replace(result.run, instruments={"press.force": cell}, zeros={"press.force": -0.25})
    (row,) = map(dict, instruments(run))
    assert row["Zero taken off"] == "-0.25 N"


def test_instrument_entry_shows_what_its_calibration_covers(result):
    cell = {
        "channel": "tester.load",
        "measures": "force",
        "id": "LC-3",
        "serial": "77",
        "certificate": "D-1",
        "laboratory": "A lab",
        "calibrated": "2026-01-02",
        "due": "2027-01-02",
        "range": {"min": "100 N", "max": "5 kN"},
        "accuracy": "0.1 % FS",
        "conditions": {
            "temperature": {"min": "18 °C", "max": "25 °C"},
            "humidity": {"min": "20 %", "max": "60 %"},
        },
    }
    angle = {"channel": "t.angle", "measures": "angle", "serial": "1", "calibration": "simulated"}
    entries = {entry["channel"]: Instrument.model_validate(entry) for entry in (cell, angle)}
    load, encoder = map(dict, instruments(replace(result.run, instruments=entries)))
    assert load["Number"] == "LC-3"
    assert load["Certificate"] == "D-1, A lab"
    assert (load["Calibrated"], load["Calibration due"]) == ("2026-01-02", "2027-01-02")
    assert (load["Range"], load["Accuracy"]) == ("100 N to 5 kN", "±0.1 % of full scale")
    assert load["Calibrated for temperature"] == "18 °C to 25 °C"
    assert load["Calibrated for humidity"] == "20 % to 60 %"
    assert encoder["Calibration"] == "none: the instrument is simulated"


def with_no_load(result, run):
    return replace(result, run=replace(result.run, partners={"no_load": run}))


def test_run_of_draft_procedure_is_not_for_certification(result):
    approved = {"state": "approved", "by": "A. Jones", "utc": "2026-02-01T10:00:00Z"}
    changed = {"state": "draft", "note": "the procedure was changed after its approval"}
    results = {
        name: replace(result, run=replace(result.run, approval=approval))
        for name, approval in (("approved", approved), ("changed", changed), ("unknown", {}))
    }
    no_load = replace(results["changed"].run, approval=approved)
    results["approved"] = with_no_load(results["approved"], no_load)
    assert run.restrictions(results["approved"]) == ()
    on_draft = with_no_load(results["approved"], replace(no_load, approval={}))
    assert run.restrictions(on_draft) == (
        "Not for certification: the procedure of the no-load run was a draft.",
    )
    assert "changed after its approval" in run.restrictions(results["changed"])[0]
    assert "Not for certification" in run.restrictions(results["unknown"])[0]
    assert dict(run.facts(results["approved"]))["State"] == ("approved by A. Jones on 2026-02-01")


def test_only_override_events_are_listed_as_overrides():
    events = [{"utc": "", "kind": kind, "text": kind} for kind in ("note", "override", "abort")]
    assert run.overrides(events) == ("override",)


def test_period_over_midnight_has_both_dates(result):
    late = replace(result.run, ended_utc="2026-03-03T00:10:00Z")
    assert dict(run.facts(replace(result, run=late)))["Performed"] == (
        "2026-03-02 09:15:00 to 2026-03-03 00:10:00 UTC"
    )


def test_settings_are_listed_under_their_plugin(result):
    assert dict(run.settings(result)) == {
        "despike › window": "11",
        "outliers › grubbs › alpha": "0.05",
        "compensations › template_inverse › support_load_dependence": "0.01",
        "primary": "template_inverse",
    }


def test_unfinished_no_load_run_gives_a_warning(result):
    assert run.warnings(result) == ()
    stopped = with_no_load(result, replace(result.run.partners["no_load"], outcome="error"))
    assert run.warnings(stopped) == (
        "The no-load run ended as 'error', not as completed: it is not a full test.",
    )


def test_several_limits_are_listed_one_by_one(result):
    decision, (mean,) = result.decision, result.decision.parts
    assert DecisionView(decision, complete=True).parts == ()
    at_35 = replace(mean, of="35 Hz", verdict=Verdict.FAIL, result=Estimate(1.2, 0.01, inf))
    rows = DecisionView(replace(decision, parts=(mean, at_35)), complete=True).parts
    assert [(row.decision.of, row.verdict.word) for row in rows] == [
        ("mean", "pass"),
        ("35 Hz", "fail"),
    ]
    assert rows[1].result.startswith("1.200 ± 0.020")


def test_risk_of_the_decision_rule_is_stated(result):
    decision = deciding(
        result.decision, guard_band=0.01, false_accept_risk=0.025, false_reject_risk=0.975
    )
    shown = DecisionView(decision, complete=True).deciding
    assert shown.risk == "at most 2.50 % of a false pass; at most 97.50 % of a false fail"
    assert shown.guard_band == "0.0100 N·m"
    without = DecisionView(result.decision, complete=True).deciding
    assert (without.risk, without.guard_band) == ("not determined", "")


def test_imported_run_names_its_program_and_author(result):
    assert run.import_notes(result) == ()
    source = {"program": "Old.vi", "by": "A. Jones"}
    loaded, no_load = (replace(data, imported=source) for data in (result.run, result.run))
    (text,) = run.import_notes(with_no_load(replace(result, run=loaded), no_load))
    assert "Old.vi made the recordings of this run and of the no-load run, not Rigrunner." in text
    by_another = replace(no_load, imported=source | {"by": "B. Lee"})
    first, second = run.import_notes(with_no_load(replace(result, run=loaded), by_another))
    assert "of this run, not" in first
    assert "as B. Lee states them" in second


def test_table_of_many_values_shows_the_first_rows_with_their_own_decimals():
    values = [0.5] * 200 + [0.125]
    units = {"press.torque": "N·m"}
    rows = [Measurement("hold", "", {}, {"press.torque": value}, units) for value in values]
    table = measured_table("hold", rows)
    assert [cells for cells, _ in table.rows] == [("0.5",)] * 200
    assert (table.columns, table.left_out) == (("press.torque / N·m",), 1)
    assert measured_table("hold", rows[-2:]).rows == ((("0.500",), None), (("0.125",), None))
