"""Contributions of a torque sensor's limits of error."""

from __future__ import annotations

from math import inf, sqrt

import pytest

from rigrunner.api.instruments import Instrument
from rigrunner_bearings.signal.sensor import reading_effects

TORQUE = {"channel": "tester.torque", "serial": "T-1", "full_scale": "20 N·m"}


@pytest.mark.parametrize("text", ["0.5 % FS", "0.5%FS", " .5 % FS "])
def test_accuracy_in_percent_of_full_scale_is_rectangular(text):
    instrument = Instrument.model_validate(TORQUE | {"accuracy": text})
    inputs = {
        effect.input.name: effect.input
        for effect in reading_effects(instrument, zeroed=True)
        if effect.sensitivity * effect.input.u
    }

    assert set(inputs) == {"sensor accuracy"}
    accuracy = inputs["sensor accuracy"]
    assert accuracy.u == pytest.approx(0.1 / sqrt(3), rel=1e-12)
    assert (accuracy.dof, accuracy.distribution) == (inf, "rectangular")
