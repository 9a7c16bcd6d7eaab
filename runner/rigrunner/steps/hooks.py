"""The kinds of steps, as records: what a lab's own plugin would declare."""

from __future__ import annotations

from rigrunner.api.hooks import StepRecord, hookimpl
from rigrunner.steps import (
    ask,
    call,
    confirm,
    measure,
    note,
    ramp,
    record,
    repeat,
    scan,
    set_drives,
    settle,
    sweep,
    wait,
    zero,
)


@hookimpl
def rigrunner_steps() -> list[StepRecord]:
    """Return the kinds of steps of the language."""
    return [
        *(confirm.STEP, ask.STEP, note.STEP, zero.STEP, set_drives.STEP, ramp.STEP, wait.STEP),
        *(settle.STEP, sweep.STEP, repeat.STEP, record.STEP, measure.STEP, scan.STEP, call.STEP),
    ]
