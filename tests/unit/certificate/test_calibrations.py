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
