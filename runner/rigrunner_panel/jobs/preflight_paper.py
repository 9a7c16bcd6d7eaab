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
            yield _good(register[channel], planned.clock.utc().date())


def _good(each: Instrument, today: date) -> PreflightItem:
    soon = each.due is not None and each.due - today <= _SOON
    paper = f"certificate {each.certificate}" if each.certificate else ""
    paper = paper or each.calibration or "no certificate"
    due = f", due {each.due}" if each.due else ""
    return PreflightItem(
        kind="calibration",
        name=each.channel,
        state="warn" if soon else "ok",
        text=f"{each.name}: {paper}{due}",
        fix="have it calibrated soon" if soon else "",
    )
