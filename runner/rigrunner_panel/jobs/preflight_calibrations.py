"""Checks from the register whether each instrument is calibrated for the run."""

from __future__ import annotations

from datetime import timedelta
from typing import TYPE_CHECKING

from rigrunner.run.calibration import calibration_findings, entering_channels
from rigrunner_panel.view.sections import PreflightItem

if TYPE_CHECKING:
    from collections.abc import Iterator
    from datetime import date

    from rigrunner.api.instruments import Instrument
    from rigrunner.run.prepare import Planned

_SOON = timedelta(days=30)


def calibrations(planned: Planned) -> Iterator[PreflightItem]:
    """Yield each problem with an instrument's calibration; for a valid one, its due date."""
    findings = calibration_findings(planned)
    for finding in findings:
        yield PreflightItem(
            kind="calibration",
            name=finding.channel,
            state="fail",
            text=finding.problem.message,
            # The rest of the hint names an option of the command line.
            fix=finding.problem.hint.split("; or start with")[0],
            override=finding.channel,
        )
    refused = {finding.channel for finding in findings}
    register = planned.station.register
    for channel in entering_channels(planned):
        if channel in register and channel not in refused:
            yield _valid(register[channel], planned.clock.utc().date())


def _valid(instrument: Instrument, today: date) -> PreflightItem:
    is_due_soon = instrument.due is not None and instrument.due - today <= _SOON
    certificate = f"certificate {instrument.certificate}" if instrument.certificate else ""
    certificate = certificate or instrument.calibration or "no certificate"
    due = f", due {instrument.due}" if instrument.due else ""
    return PreflightItem(
        kind="calibration",
        name=instrument.channel,
        state="warn" if is_due_soon else "ok",
        text=f"{instrument.name}: {certificate}{due}",
        fix="have it calibrated soon" if is_due_soon else "",
    )
