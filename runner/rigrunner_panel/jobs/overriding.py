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
    words = [each.override for each in job.items if each.kind == "calibration"]
    by, reason = (job.by, job.reason) if words else ("", "")
    yield from overrides_for(planned, words, by, reason)
    for each in job.items:
        if each.kind != "calibration":
            yield Override(f"{each.kind} {each.name}", each.text, job.by, job.reason)
