"""Procedures: what ships loads, and what is in a model is what stands in the file."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from helpers_language import PROCEDURE, edited
from rigrunner.procedure import load_procedure, parse_procedure
from rigrunner.signal import spikes
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


def test_the_analysis_is_what_its_section_says():
    model = parse_procedure(PROCEDURE, "p.yaml").model
    spec = model.torque_analysis

    assert (spec.no_load.from_, spec.no_load.procedure) == ("latest", "TEST-0")
    assert spec.no_load.max_age == 30 * 24 * 3600
    assert spec.no_load.same == ("station", "mandrel")
    assert spec.despike.window == 11
    assert (spec.outliers.name, spec.outliers.settings) == ("grubbs", {"alpha": 0.05})
    assert [(fit.name, fit.settings) for fit in spec.fits] == [
        ("polynomial", {"degree": 2}),
        ("inertia", {}),
    ]
    assert [each.name for each in spec.compensations] == ["template", "energy"]
    (limit,) = model.acceptance.limits
    assert (limit.of, limit.mean, str(limit.max), limit.min) == ("torque", True, "0.95 N·m", None)
    assert model.acceptance.rule.name == "guard_band_u"


def test_a_plugin_with_an_empty_value_has_no_settings():
    text = edited(PROCEDURE, ("        - inertia\n", "        - inertia:\n"))

    assert parse_procedure(text, "p.yaml").model.torque_analysis.fits[1].settings == {}


def test_a_plugin_may_stand_twice_under_names_of_its_own():
    text = edited(
        PROCEDURE,
        ("        - energy\n", "        - energy\n        - {energy: {a: 1}, as: other}\n"),
        ("primary: template", "primary: other"),
    )
    spec = parse_procedure(text, "p.yaml").model.torque_analysis

    assert [(each.name, each.label) for each in spec.compensations] == [
        ("template", "template"), ("energy", "energy"), ("energy", "other"),
    ]  # fmt: skip
    assert spec.compensations[2].settings == {"a": 1}
    assert spec.primary == "other"


def test_the_only_compensation_is_the_primary_one():
    text = edited(PROCEDURE, ("        - energy\n", ""), ("      primary: template\n", ""))

    assert parse_procedure(text, "p.yaml").model.torque_analysis.primary == "template"


def test_the_threshold_for_spikes_is_that_of_the_filter_unless_told():
    assert parse_procedure(PROCEDURE, "p.yaml").model.torque_analysis.despike.threshold == (
        spikes.DEFAULT_THRESHOLD
    )
    text = edited(PROCEDURE, ("window: 11", "window: 11, threshold: 4"))
    assert parse_procedure(text, "p.yaml").model.torque_analysis.despike.threshold == 4.0


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
    assert model.torque_analysis.compensations == ()


def test_sweeps_nest():
    inner = "{sweep: {set: tester.load, over: [1 N], steps: [settle: {time: 1 s}]}}"
    text = edited(PROCEDURE, ("settle: {cycles: 5}", inner[1:-1]))
    (settle,) = parse_procedure(text, "p.yaml").model.main[1].settings.steps[0].settings.steps

    assert settle.settings.time == 1.0
