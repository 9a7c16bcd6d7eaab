from __future__ import annotations

from dataclasses import replace

from rigrunner.api.data import Estimate
from rigrunner_bearings.api.validation import Agreement, EquationTrials, PipelineDraws, Validation
from rigrunner_bearings.report.view.validation import validation
from rigrunner_reports.render import html
from unit.rigrunner_reports.helpers_report import loaded_result, report_input, torque_of

GUM = Estimate(0.7273, 0.00479)


def agreement(frequency_hz, half_nm, *, agrees):
    return Agreement(
        set_frequency_hz=frequency_hz,
        gum=GUM,
        gum_low=0.7179,
        gum_high=0.7367,
        mean=0.7273,
        u=0.0048,
        low=0.7273 - half_nm,
        high=0.7273 + half_nm,
        tolerance=0.0005,
        resolution=0.0014,
        agrees=agrees,
    )


def checked(half_nm=0.0087, *, stable=True, refused=0):
    mean, point = (agreement(hz, half_nm, agrees=False) for hz in (None, 35.0))
    same = agreement(None, 0.0094, agrees=True)
    return Validation(
        method="template_inverse",
        digits=1,
        seed=7,
        equation=EquationTrials(mean, (point,), 1_000_000, stable),
        pipeline=PipelineDraws(same, (same,), 500, refused, ("sensor gain",), ("finite band",)),
    )


def test_no_view_without_validation():
    assert validation(torque_of(loaded_result())) is None


def test_table_has_rows_for_mean_and_each_set_point():
    mean, point = validation(torque_of(loaded_result(validation=checked()))).rows
    assert (mean.of, point.of) == ("mean", "35 Hz")
    assert mean.u == ("4.8", "4.8", "4.8")
    assert mean.intervals == (
        "0.7179 to 0.7367",
        "0.7186 to 0.7360",
        "0.7179 to 0.7367",
    )
    assert mean.agree == ("no", "yes")


def test_statement_names_interval_to_use_and_side_of_error():
    trials, draws = checked().statements
    assert "does not agree" in trials
    assert "0.7 mN·m, and 0.5 mN·m is allowed" in trials
    assert "safe, and too wide. Use the Monte Carlo interval, 0.7186 N·m to 0.7360 N·m" in trials
    assert "agrees with 500 draws" in draws
    assert "interval" not in draws.partition("agrees")[2]
    wider = replace(checked(), equation=checked(0.012).equation)
    assert "too narrow on a side" in wider.statements[0]


def test_refused_draws_and_unsettled_trials_are_noted():
    notes = validation(torque_of(loaded_result(validation=checked(stable=False, refused=3)))).notes
    assert any("refused 3 draws" in note for note in notes)
    assert any("had not settled" in note for note in notes)
    assert len(validation(torque_of(loaded_result(validation=checked()))).notes) == 3


def test_validation_is_in_uncertainty_section():
    page = html(report_input(loaded_result(validation=checked()))).decode()
    section = page[page.index('id="uncertainty"') :]
    section = section[: section.index("</section>")]
    assert "Checked by Monte Carlo" in section
    assert "0.7186 to 0.7360" in section
    assert "Checked by Monte Carlo" not in html(report_input(loaded_result())).decode()
