"""What a torque sensor's limits of error contribute."""

from __future__ import annotations

from math import inf, sqrt

import pytest

from rigrunner.api.instruments import Instrument
from rigrunner_bearings.signal.sensor import reading_effects

TORQUE = {"channel": "tester.torque", "serial": "T-1", "full_scale": "20 N·m"}


@pytest.mark.parametrize("text", ["0.5 % FS", "0.5%FS", " .5 % FS "])
def test_an_accuracy_in_one_figure_is_rectangular_over_full_scale(text):
    instrument = Instrument.model_validate(TORQUE | {"accuracy": text})
    told = {
        each.input.name: each.input
        for each in reading_effects(instrument, zeroed=True)
        if each.sensitivity * each.input.u
    }

    assert set(told) == {"sensor accuracy"}
    accuracy = told["sensor accuracy"]
    assert accuracy.u == pytest.approx(0.1 / sqrt(3), rel=1e-12)
    assert (accuracy.dof, accuracy.distribution) == (inf, "rectangular")
