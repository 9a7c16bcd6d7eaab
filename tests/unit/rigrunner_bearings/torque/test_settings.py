"""The settings of the analyses of torque."""

from __future__ import annotations

import pytest

from helpers_language import PROCEDURE, edited
from rigrunner.api import DataError
from rigrunner.procedure import parse_procedure
from rigrunner.signal import spikes
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.torque.contradictions import changed
from rigrunner_bearings.torque.settings import Breakaway, SwingTorque

AT_REVERSAL = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
TWO = {
    "no_load": {"from": "latest", "procedure": "TEST-0"},
    "compensations": ["template", "energy"],
    "primary": "template",
}


def settings_of(text):
    (analysis,) = parse_procedure(text, "p.yaml").model.analysis
    return SwingTorque.model_validate(analysis.settings)


def test_they_are_what_the_procedure_says():
    spec = settings_of(PROCEDURE)
    assert (spec.no_load.from_, spec.no_load.procedure) == ("latest", "TEST-0")
    assert spec.no_load.max_age == 30 * 24 * 3600
    assert spec.no_load.same == ("station", "mandrel")
    assert spec.despike.window == 11
    assert (spec.outliers.name, spec.outliers.settings) == ("grubbs", {"alpha": 0.05})
    assert [(fit.name, fit.settings) for fit in spec.fits] == [
        ("polynomial", {"degree": 2}),
        ("inertia", {}),
    ]
    assert [compensation.name for compensation in spec.compensations] == ["template", "energy"]


def test_a_plugin_with_an_empty_value_has_no_settings():
    text = edited(PROCEDURE, ("        - inertia\n", "        - inertia:\n"))
    assert settings_of(text).fits[1].settings == {}


def test_a_plugin_may_stand_twice_under_names_of_its_own():
    text = edited(
        PROCEDURE,
        ("        - energy\n", "        - energy\n        - {energy: {a: 1}, as: other}\n"),
        ("primary: template", "primary: other"),
    )
    spec = settings_of(text)
    assert [(compensation.name, compensation.label) for compensation in spec.compensations] == [
        ("template", "template"),
        ("energy", "energy"),
        ("energy", "other"),
    ]
    assert spec.compensations[2].settings == {"a": 1}
    assert spec.primary == "other"


def test_the_only_compensation_is_the_primary_one():
    text = edited(PROCEDURE, ("        - energy\n", ""), ("      primary: template\n", ""))
    assert settings_of(text).primary == "template"


def test_the_threshold_for_spikes_is_that_of_the_filter_unless_told():
    assert settings_of(PROCEDURE).despike.threshold == spikes.DEFAULT_THRESHOLD
    text = edited(PROCEDURE, ("window: 11", "window: 11, threshold: 4"))
    assert settings_of(text).despike.threshold == 4.0


def test_of_starts_from_rest_no_method_gives_the_torque_at_a_reversal():
    from_rest = MeasurandKind(Nature.LOAD_INDUCED, Condition.FROM_REST)
    assert Breakaway().measured(AT_REVERSAL) == from_rest
    assert SwingTorque().measured(AT_REVERSAL) == AT_REVERSAL


def test_what_was_given_stands_in_place_of_what_was_told():
    overrides = SwingTorque.model_validate(
        {"primary": "energy", "despike": {"hampel": {"window": 7}}}
    )
    merged = changed(SwingTorque.model_validate(TWO), overrides)
    assert (merged.primary, merged.despike.window) == ("energy", 7)
    assert merged.no_load.procedure == "TEST-0"  # not given


def test_a_run_without_compensations_stays_without():
    overrides = SwingTorque.model_validate({"primary": "energy", "compensations": ["energy"]})
    assert changed(SwingTorque(), overrides) == SwingTorque()


def test_a_change_that_contradicts_the_rest_is_refused():
    overrides = SwingTorque.model_validate({"primary": "nothing"})
    with pytest.raises(DataError, match="primary: got 'nothing', which is not among") as refused:
        changed(SwingTorque.model_validate(TWO), overrides)
    assert refused.value.hint == "allowed: template, energy"
