"""Procedures: what ships loads, and what is in a model is what stands in the file."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from helpers_language import PROCEDURE, edited
from rigrunner.api.errors import InvalidFileError
from rigrunner.procedure import load_procedure, parse_procedure
from rigrunner.steps.confirm import ConfirmStep
from rigrunner.steps.record import RecordStep
from rigrunner.steps.set_drives import SetStep
from rigrunner.steps.settle import SettleStep
from rigrunner.steps.sweep import SweepStep

SHIPPED = Path(__file__).parents[3] / "procedures"


@pytest.mark.parametrize("path", sorted(SHIPPED.glob("*.yaml")), ids=lambda path: path.stem)
def test_what_ships_loads(path):
    loaded = load_procedure(path)

    assert loaded.text == path.read_text(encoding="utf-8")
    assert loaded.digest == hashlib.sha256(path.read_bytes()).hexdigest()


def test_both_shipped_sweeps_go_through_the_same_frequencies():
    sweeps = [
        load_procedure(SHIPPED / f"{name}.yaml").model.parameters["frequencies"]
        for name in ("no_load_inertia_sweep", "starting_torque_1000n")
    ]

    assert sweeps[0] == sweeps[1]
    assert len(sweeps[0]) == 12


def test_a_measurand_may_be_of_any_quantity_where_no_torque_is_analysed():
    text = PROCEDURE.replace("name: torque, unit: N·m", "name: resistance, unit: Ω")
    without = parse_procedure(text.partition("\nanalysis:")[0] + "\n", "p.yaml").model
    assert without.measurand.unit == "Ω"


def test_a_procedure_is_what_its_file_says():
    model = parse_procedure(PROCEDURE, "p.yaml").model

    assert (model.id, model.revision, model.measurand.unit) == ("TEST-1", "A", "N·m")
    assert model.inputs["specimen"].unattended == "S-1"
    assert model.uses == {"tester": "swing_tester"}
    confirm, _, targets, zero = model.setup
    assert isinstance(confirm.settings, ConfirmStep)
    assert confirm.settings.unattended is True
    assert isinstance(targets.settings, SetStep)
    assert [str(value) for value in targets.settings.drives.values()] == ["0 N", "0 Hz"]
    assert zero.settings.duration == 1.0
    load, sweep = model.main
    assert load.settings.drives["tester.load"].si == 1000.0
    assert isinstance(sweep.settings, SweepStep)
    assert [value.si for value in sweep.settings.over] == [2.0, 10.0]
    settle, record = sweep.settings.steps
    assert isinstance(settle.settings, SettleStep)
    assert (settle.settings.cycles, settle.settings.time) == (5, None)
    assert isinstance(record.settings, RecordStep)
    assert record.settings.channels == ("tester.angle", "tester.torque")


def test_an_analysis_is_named_with_its_settings_as_they_are_written():
    model = parse_procedure(PROCEDURE, "p.yaml").model
    ((at, analysis),) = model.analyses_at

    assert at == ("analysis", 0, "swing_torque")
    assert analysis.name == "swing_torque"
    assert analysis.settings["outliers"] == {"grubbs": {"alpha": 0.05}}
    (limit,) = model.acceptance.limits
    assert (limit.of, limit.mean, str(limit.max), limit.min) == ("torque", True, "0.95 N·m", None)
    assert model.acceptance.rule.name == "guard_band_u"


WRONG_TWICE = """\
rigrunner: procedure/2
id: TEST-1
revision: "A"
title: A test
uses: {meter: multimeter}
main:
  - setle: 5 s
analysis:
  - readings: {of: meter.voltage, statistic: mean, resultt: mean voltage}
"""


def test_settings_of_an_analysis_are_told_beside_all_other_mistakes():
    with pytest.raises(InvalidFileError) as refused:
        parse_procedure(WRONG_TWICE, "p.yaml")
    problems = {problem.field: problem for problem in refused.value.problems}
    assert "unknown step 'setle'" in problems["main[0]"].message
    unknown_key = problems["analysis[0].readings.resultt"]
    assert (unknown_key.location.line, unknown_key.message) == (9, "unknown key 'resultt'")
    assert "did you mean 'result" in unknown_key.hint


def test_settings_of_an_analysis_that_is_not_known_or_of_a_stored_run_are_left_alone():
    text = WRONG_TWICE.replace("setle: 5 s", "settle: {time: 5 s}")
    unknown = text.replace("readings:", "readings_of_my_lab:")
    assert parse_procedure(unknown, "p.yaml").model.analysis[0].name == "readings_of_my_lab"
    assert parse_procedure(text, "p.yaml", stored=True).model.analysis[0].name == "readings"


def test_a_stored_text_gives_the_same_procedure(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + PROCEDURE.replace("\n", "\r\n").encode())
    loaded = load_procedure(path)
    stored = parse_procedure(loaded.text, "run.h5")

    assert loaded.text == PROCEDURE.replace("\n", "\r\n")
    assert stored.digest == loaded.digest
    assert stored.model == loaded.model == parse_procedure(PROCEDURE, "p.yaml").model


def test_sections_may_be_left_out():
    lines = PROCEDURE.splitlines(keepends=True)
    text = "".join(lines[: lines.index("setup:\n")]) + "main: [settle: {time: 1 s}]\n"
    model = parse_procedure(text, "p.yaml").model

    assert (model.setup, model.teardown, model.acceptance) == ((), (), None)
    assert model.analysis == ()


def test_sweeps_nest():
    inner = "{sweep: {set: tester.load, over: [1 N], steps: [settle: {time: 1 s}]}}"
    text = edited(PROCEDURE, ("settle: {cycles: 5}", inner[1:-1]))
    (settle,) = parse_procedure(text, "p.yaml").model.main[1].settings.steps[0].settings.steps

    assert settle.settings.time == 1.0
