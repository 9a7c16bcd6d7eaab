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
TWO_METHODS = {
    "no_load": {"from": "latest", "procedure": "TEST-0"},
    "compensations": ["template", "energy"],
    "primary": "template",
}


def settings_of(text):
    (analysis,) = parse_procedure(text, "p.yaml").model.analysis
    return SwingTorque.model_validate(analysis.settings)


def test_settings_are_read_from_procedure():
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


def test_plugin_with_empty_value_has_no_settings():
    text = edited(PROCEDURE, ("        - inertia\n", "        - inertia:\n"))
    assert settings_of(text).fits[1].settings == {}


def test_plugin_may_appear_twice_with_labels():
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


def test_only_compensation_is_primary():
    text = edited(PROCEDURE, ("        - energy\n", ""), ("      primary: template\n", ""))
    assert settings_of(text).primary == "template"


def test_spike_threshold_defaults_to_that_of_filter():
    assert settings_of(PROCEDURE).despike.threshold == spikes.DEFAULT_THRESHOLD
    text = edited(PROCEDURE, ("window: 11", "window: 11, threshold: 4"))
    assert settings_of(text).despike.threshold == 4.0


def test_starts_from_rest_never_give_torque_at_reversal():
    from_rest = MeasurandKind(Nature.LOAD_INDUCED, Condition.FROM_REST)
    assert Breakaway().measured(AT_REVERSAL) == from_rest
    assert SwingTorque().measured(AT_REVERSAL) == AT_REVERSAL


def test_overrides_replace_settings_of_run():
    overrides = SwingTorque.model_validate(
        {"primary": "energy", "despike": {"hampel": {"window": 7}}}
    )
    merged = changed(SwingTorque.model_validate(TWO_METHODS), overrides)
    assert (merged.primary, merged.despike.window) == ("energy", 7)
    assert merged.no_load.procedure == "TEST-0"  # not given


def test_run_without_compensations_keeps_none():
    overrides = SwingTorque.model_validate({"primary": "energy", "compensations": ["energy"]})
    assert changed(SwingTorque(), overrides) == SwingTorque()


def test_contradictory_override_is_refused():
    overrides = SwingTorque.model_validate({"primary": "nothing"})
    with pytest.raises(DataError, match="primary: got 'nothing', which is not among") as caught:
        changed(SwingTorque.model_validate(TWO_METHODS), overrides)
    assert caught.value.hint == "allowed: template, energy"
