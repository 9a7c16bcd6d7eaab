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


def test_resolution_is_stated_as_the_step_that_it_is():
    entry = Instrument.model_validate(
        {"channel": "meter.voltage", "measures": "voltage", "serial": "M-1", "certificate": "C-1",
         "accuracy": {"resolution": "10 mV", "offset": "2 mV"}}
    )  # fmt: skip
    (certified,) = instruments_of(run_of(instruments=[entry]))
    assert dict(certified.uncertainty) == {"limit_resolution": "10 mV", "limit_offset": "±2 mV"}
