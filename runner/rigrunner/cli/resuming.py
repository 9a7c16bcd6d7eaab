"""Report an interrupted run: what is stored, and where it continues."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rigrunner.cli.output import message
from rigrunner.engine import restoring_step
from rigrunner.run.resume import how_it_ended

if TYPE_CHECKING:
    from rigrunner.run.resume import ResumableRun
    from rigrunner.runfile import StoredRun


def show_resumable(run: ResumableRun) -> None:
    """Print on stderr what is stored and what comes next."""
    message(f"{run.stored.header.run_id}: {how_it_ended(run.stored)}")
    message(on_disk(run.stored))
    if run.resume_at is None:
        message("  the run had ended: only analysis, file and report are missing")
        return
    steps, resume_at = run.planned.plan.steps, run.resume_at
    if resume_at.before:
        repeated = (restoring_step(steps[index]).text for index in resume_at.before)
        message(f"  once more: {'; '.join(repeated)}")
    if resume_at.start < len(steps):
        step, number = steps[resume_at.start], resume_at.start + 1
        message(f"  resumes at {step.path}: {step.text} (step {number} of {len(steps)})")


def on_disk(stored: StoredRun) -> str:
    """Return the content of a run, a line for each kind."""
    interrupted = (
        f"interrupted: {part.name}, of which {part.samples / part.rate_hz:.1f} s are kept"
        for part in stored.incomplete
    )
    names = stored.info.recording_names
    finished = ", ".join(names) or "none"
    if len(names) > 1:
        finished = f"{len(names)}, {names[0]} to {names[-1]}"
    tables = Counter(row.name for row in stored.measurements)
    measured = (f"measured: {name}, {rows} rows" for name, rows in tables.items())
    lines = [f"finished recordings: {finished}", *measured, *interrupted, *stored.notes]
    return "\n".join(f"  {line}" for line in lines)
