"""Calibrations on a certificate: whether each was valid until the end of the run."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rigrunner.api.instruments import Instrument
from rigrunner.certificate.surroundings import instruments_of
from unit.rigrunner_plugins.test_readings import run_of


@pytest.mark.parametrize(("due", "overdue"), [("01-05", True), ("01-06", True), ("01-07", False)])
def test_calibration_that_expired_during_the_run_is_overdue(due, overdue):
    entry = Instrument.model_validate(
        {"channel": "meter.voltage", "measures": "voltage", "serial": "M-1", "certificate": "C-1",
         "due": f"2026-{due}"}
    )  # fmt: skip
    run = replace(
        run_of(instruments=[entry]),
        started_utc="2026-01-06T23:00:00.000Z",
        ended_utc="2026-01-07T01:00:00.000Z",
    )

    (certified,) = instruments_of(run)

    assert certified.overdue is overdue


def entry_of(**keys):
    meter = {"channel": "meter.voltage", "measures": "voltage", "serial": "M-1", **keys}
    (entry,) = instruments_of(run_of(instruments=[Instrument.model_validate(meter)]))
    return entry.uncertainty


def test_resolution_is_a_step_without_sign_and_small_gain_is_as_written():
    accuracy = {"gain": "0.1 ppm", "resolution": "0.01 V"}

    assert entry_of(accuracy=accuracy) == {
        "limit_gain": "±0.1 ppm reading",
        "limit_resolution": "0.01 V",
    }


@pytest.mark.parametrize(
    ("keys", "name"), [({}, "points"), ({"interpolation": "linear"}, "corrected_by_points")]
)
def test_certificate_states_whether_points_correct_the_readings(keys, name):
    points = [
        {"applied": "1 V", "indicated": "1.01 V", "U": "1 mV"},
        {"applied": "2 V", "indicated": "2.02 V", "U": "1 mV"},
    ]

    stated = {name: "1 V: 1.01 V, U = 1 mV (k = 2); 2 V: 2.02 V, U = 1 mV (k = 2)"}
    assert entry_of(points=points, **keys) == stated
