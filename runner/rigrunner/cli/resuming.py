"""Report an interrupted run: what is stored, and where it continues."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rigrunner.cli.output import message
from rigrunner.engine import brought_back
from rigrunner.run.resume import how_it_ended

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.engine import ResumePoint
    from rigrunner.plan import Plan
    from rigrunner.run.resume import ResumableRun
    from rigrunner.runfile import StoredRun


def tell_resumable(run: ResumableRun) -> None:
    """Print on stderr what is stored and what comes next."""
    message(f"{run.stored.header.run_id}: {how_it_ended(run.stored)}")
    message(on_disk(run.stored))
    if run.resume_at is None:
        message("  the run had ended: only analysis, file and report are missing")
        return
    for line in _next(run.planned.plan, run.resume_at):
        message(f"  {line}")


def on_disk(stored: StoredRun) -> str:
    """Return the content of a run, a line for each kind."""
    interrupted = (
        f"interrupted: {each.name}, of which {each.samples / each.rate_hz:.1f} s are kept"
        for each in stored.incomplete
    )
    finished = f"finished recordings: {_names(stored.info.recording_names)}"
    tables = Counter(each.name for each in stored.measurements)
    measured = (f"measured: {name}, {rows} rows" for name, rows in tables.items())
    lines = [finished, *measured, *interrupted, *stored.notes]
    return "\n".join(f"  {line}" for line in lines)


def _next(plan: Plan, resume_at: ResumePoint) -> Iterator[str]:
    if resume_at.before:
        again = (brought_back(plan.steps[index]).text for index in resume_at.before)
        yield f"once more: {'; '.join(again)}"
    if resume_at.start < len(plan.steps):
        step = plan.steps[resume_at.start]
        number, count = resume_at.start + 1, len(plan.steps)
        yield f"resumes at {step.path}: {step.text} (step {number} of {count})"


def _names(names: tuple[str, ...]) -> str:
    if len(names) > 1:
        return f"{len(names)}, {names[0]} to {names[-1]}"
    return names[0] if names else "none"
