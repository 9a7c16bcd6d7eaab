"""A step and its attempts: completed, repeated, skipped, or the end of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Alarm
from rigrunner.api.steps import NOTHING
from rigrunner.engine.attempt import Attempt
from rigrunner.engine.notes import CONTINUES, error_line
from rigrunner.engine.pausing import PauseRequestedError

if TYPE_CHECKING:
    from collections import Counter

    from rigrunner.engine.notes import Notes
    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import PlannedStep


class Done(NamedTuple):
    """How a step ended, other than by an error that ends the run."""

    missed: str = ""
    """The values out of limits that stop the run, as text; '' for none."""
    leaves: int = 0
    """Number of following steps to skip."""


def do_step(
    index: int, step: PlannedStep, session: Session, notes: Notes, attempts: Counter[int]
) -> Done:
    """Execute a step, and repeat it after failures as its terms allow.

    Return whether values out of limits stop the run, and what is skipped. `attempts` counts the
    attempts of each step by index, so that names of recordings are unique. Raises other errors that
    end the run, and PauseRequestedError if a pause interrupted the step.
    """
    for number in range(1, step.terms.attempts + 1):
        attempts[index] = total = attempts.get(index, 0) + 1
        done = _try(Attempt(index, step, number, total, session.rig.cycles), session, notes)
        if done is not None:
            return done
    return Done()  # the last attempt failed, and the run continues


def _try(attempt: Attempt, session: Session, notes: Notes) -> Done | None:
    """Return how the step ended; None if it failed, and is repeated or passed over.

    Raises errors that end the run. A value is recorded before it is judged: it counts, and is not
    read again.
    """
    step, result = attempt.step, NOTHING
    terms = step.terms
    step_session = session if terms.timeout_s is None else session.within(terms.timeout_s)
    attempt.begin(session.emit)
    if attempt.action.drives_stay:
        step_session = step_session.reading
    try:
        # Before and after: a drive may leave its set-point between steps, or during one that is
        # shorter than the interval.
        step_session.check_drives()
        result = attempt.action.do(step.path, step_session)
        step_session.check_drives()
        if step_session.timeout_s is not None:
            step_session.check_time()
    except PauseRequestedError as request:
        # With `try_emit`: the error of a sink must not take the place of the pause.
        attempt.end(notes.try_emit, result, ok=False)
        if terms.repeatable:
            raise PauseRequestedError(request.message, request.by) from request
        text = f"{step.path}: {request.message}, inside a step that cannot be repeated"
        raise AbortedError(text, by=request.by) from request
    except BaseException as error:
        # What the driver logged often explains the error, and is recorded before it.
        session.put_messages()
        retry, passed_over = _failed(attempt, error, notes)
        attempt.end(notes.try_emit, result, ok=False)
        if retry or passed_over:
            return None
        raise
    attempt.end(session.emit, result, ok=True)
    # A step that judges its values itself, or is a condition, has no limits in its terms.
    if not (terms.limits or terms.expected):
        return Done(result.missed, step.leaves if result.leaves else 0)
    missed = session.judge(
        step.path,
        terms.limits,
        {**result.values, **result.statistics},
        expected=terms.expected,
        readings=result.readings,
    )
    return Done(missed if terms.stops_at_limit else "")


def _failed(attempt: Attempt, error: BaseException, notes: Notes) -> tuple[bool, bool]:
    """Record a failure; return whether to repeat the step, and whether to continue without it."""
    path = attempt.step.path
    # Another attempt is useless: it could not be recorded either.
    if notes.prevents_recording(error):
        notes.note(path, error)
        return False, False
    retry, passed_over = attempt.may_retry(error), attempt.may_continue(error)
    if retry:
        attempts = attempt.step.terms.attempts
        text = f"{error_line(error)}; try {attempt.number} of {attempts}"
        notes.try_emit(Alarm, source=path, text=text)
        notes.trace(error)
    elif passed_over:
        notes.pass_over(f"{path}: {error_line(error)}")
        notes.try_emit(Alarm, source=path, text=error_line(error) + CONTINUES)
        notes.trace(error)
    else:
        notes.note(path, error)
    return retry, passed_over
