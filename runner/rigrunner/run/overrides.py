"""Overrides of calibration checks at the start of a run, with name and reason."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.clock import SimulatedClock
from rigrunner.engine import Interference, Override
from rigrunner.run.calibration import calibration_findings, require_calibrated

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from datetime import datetime

    from rigrunner.run.calibration import Finding
    from rigrunner.run.prepare import Planned
    from rigrunner.station import LoadedStation


def overrides_for(
    planned: Planned, names: Sequence[str], by: str, reason: str
) -> tuple[Override, ...]:
    """Return the overrides for a planned run; none if nothing fails.

    `names` are instruments (channel, number or serial number) or problems (missing, overdue,
    range). Raises InvalidFileError with everything not overridden, and UsageError for an override
    without name or reason, or without a failed check.
    """
    by, reason = by.strip(), reason.strip()
    if names and not (by and reason):
        missing = " and ".join(
            option for option, value in (("--by NAME", by), ("--reason TEXT", reason)) if not value
        )
        raise UsageError(
            f"an override needs {missing}", hint="both are recorded in the run file and the report"
        )
    if (by or reason) and not names:
        raise UsageError(
            "--by and --reason need --override",
            hint="give --override INSTRUMENT, or leave them out",
        )
    findings = calibration_findings(planned)
    for name in names:
        if not any(_matches(name, finding) for finding in findings):
            texts = ", ".join(f"{finding.names[-1]} ({finding.lack})" for finding in findings)
            hint = f"what prevents this run from starting: {texts}"
            raise UsageError(
                f"'--override {name}' matches nothing",
                hint=hint if findings else "nothing prevents this run from starting",
            )
    overrides = tuple(
        Override(finding.key, finding.problem.message, by, reason)
        for finding in findings
        if any(_matches(name, finding) for name in names)
    )
    require_overridden(planned, overrides)
    return overrides


def require_overridden(planned: Planned, overrides: Iterable[Override]) -> None:
    """Raise InvalidFileError with everything that prevents a start and is not overridden."""
    require_calibrated(planned, {override.what for override in overrides})


def require_still_allowed(planned: Planned, started: datetime) -> None:
    """Raise InvalidFileError with what fails since the run was started."""
    at_start = replace(planned, clock=SimulatedClock(started))
    require_calibrated(planned, {finding.key for finding in calibration_findings(at_start)})


def _matches(name: str, finding: Finding) -> bool:
    return name == finding.lack or name in finding.names


def without_time_limits(station: LoadedStation) -> tuple[Interference, ...]:
    """Return the record of suspended time limits of a run; empty for none."""
    if station.time_limits:
        return ()
    text = "no call of a device is given up, however long it takes"
    return (Interference("suspend time limits", "option --debugger", subject=text),)
