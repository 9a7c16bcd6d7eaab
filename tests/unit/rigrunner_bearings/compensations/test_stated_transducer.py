"""Transducer errors that the register states reach the budget of every method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helpers_rigs import INSTRUMENT
from rigrunner.api.accuracy import Accuracy
from rigrunner.api.filters import MeasuredResponse
from rigrunner.registry import load_registry
from rigrunner_bearings.compensations.response import butterworth
from rigrunner_bearings.devices.swing_tester_sim.parameters import RigParameters
from unit.rigrunner_bearings.compensations.helpers_sweeps import FEW, sweep_of

REGISTRY = load_registry()
SOURCE = "DKD-K-12345"
ERRORS = Accuracy.model_validate(
    {
        "repeatability": {"limit": "0.05 % reading", "source": SOURCE},
        "hysteresis": {"limit": "0.1 % FS", "source": SOURCE},
        "temperature_sensitivity": {
            "limit": "0.2 % reading", "per": "10 K", "within": "5 K", "source": SOURCE,
        },
    }
).limits  # fmt: skip
METHODS = ("template_inverse", "model_inverse", "energy", "paper_peak", "peak_same_frequency")


def compensated(method, **changes):
    sweep = sweep_of(RigParameters(), FEW)
    fit = REGISTRY.make("fit", "polynomial", {"degree": 2})
    instrument = INSTRUMENT.model_copy(update=changes)
    return REGISTRY.make("compensation", method, {})(replace(sweep, instrument=instrument, fit=fit))


@pytest.mark.parametrize("method", METHODS)
def test_stated_errors_are_in_every_budget(method):
    plain, stated = (
        compensated(method),
        compensated(method, accuracy_=INSTRUMENT.accuracy.model_copy(update=ERRORS)),
    )
    for before, after in zip(plain.points, stated.points, strict=True):
        assert after.torque.value == before.torque.value
        lines = {
            component.name: component.u
            for component in after.components
            if SOURCE in component.name
        }
        assert set(lines) == {
            f"transducer {name} ({SOURCE})"
            for name in ("repeatability", "hysteresis", "temperature effect on sensitivity")
        }
        # 0.1 % of the result of the torque, as the gain's
        assert lines[f"transducer temperature effect on sensitivity ({SOURCE})"] == pytest.approx(
            1e-3 * abs(after.torque.value) / np.sqrt(3), rel=0.01
        )
        # 0.1 % of 10 N·m in each of two runs
        assert lines[f"transducer hysteresis ({SOURCE})"] == pytest.approx(
            0.01 * np.sqrt(2 / 3), rel=0.01
        )
        added = sum(u**2 for u in lines.values())
        assert after.torque.u == pytest.approx(np.sqrt(before.torque.u**2 + added), rel=1e-6)


def test_filter_given_by_response_equals_named_filter():
    hertz = np.geomspace(5, 5000, 200)
    table = [
        {"frequency": f"{f!r} Hz", "gain": float(abs(h)), "phase": f"{float(np.angle(h))!r} rad"}
        for f, h in zip(hertz.tolist(), butterworth(hertz, 1000.0, 2), strict=True)
    ]
    low_pass = MeasuredResponse.model_validate(
        {"type": "measured", "response": table, "source": SOURCE}
    )
    named, measured = (
        compensated("template_inverse"),
        compensated("template_inverse", low_pass=low_pass),
    )
    for one, other in zip(named.points, measured.points, strict=True):
        assert other.torque.value == pytest.approx(one.torque.value, abs=1e-4)
        assert other.torque.u == pytest.approx(one.torque.u, rel=0.02)
