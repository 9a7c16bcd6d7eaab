"""Overrides made at the panel before a job, in the form that the run's record takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.engine import Override
from rigrunner.run.overrides import overrides_for

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.run.prepare import Planned
    from rigrunner_panel.process.messages import Job


def overrides_of(planned: Planned, job: Job) -> Iterator[Override]:
    """Yield the overrides of calibrations and of other preflight checks."""
    names = [item.override for item in job.items if item.kind == "calibration"]
    by, reason = (job.by, job.reason) if names else ("", "")
    yield from overrides_for(planned, names, by, reason)
    for item in job.items:
        if item.kind != "calibration":
            yield Override(f"{item.kind} {item.name}", item.text, job.by, job.reason)
