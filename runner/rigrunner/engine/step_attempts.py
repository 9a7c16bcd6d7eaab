"""A step and its attempts: completed, repeated, skipped, or the end of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Alarm
from rigrunner.api.steps import NOTHING
from rigrunner.engine.attempt import Attempt
from rigrunner.engine.notes import GOES_ON, words
from rigrunner.engine.pausing import PauseWantedError

if TYPE_CHECKING:
    from collections import Counter

    from rigrunner.engine.notes import Notes
    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import PlannedStep


class Done(NamedTuple):
    """How a step ended that does not end the run by an error."""

    missed: str = ""
    """The values out of limits that are to stop the run, in words; '' for none."""
    leaves: int = 0
    """How many of the steps that follow are left out."""


def do_step(
    index: int, step: PlannedStep, session: Session, notes: Notes, attempts: Counter[int]
) -> Done:
    """Do one step, and again after a failure for as long as its terms allow.

    Return whether values out of limits stop the run, and what follows is left out. `attempts` has
    by index how often each step was begun, so that no two recordings have the same name. Raises
    what ends the run otherwise, and PauseWantedError if a pause broke the step off.
    """
    for number in range(1, step.terms.tries + 1):
        attempts[index] = total = attempts.get(index, 0) + 1
        done = _try(Attempt(index, step, number, total, session.rig.cycles), session, notes)
        if done is not None:
            return done
    return Done()


def _try(attempt: Attempt, session: Session, notes: Notes) -> Done | None:
    """Return how the step ended; None where it is tried again.

    Raises what ends the run otherwise. A value is on record before it is judged: what was read
    counts, and is not read again.
    """
    step, found = attempt.step, NOTHING
    terms = step.terms
    trial = session if terms.timeout_s is None else session.within(terms.timeout_s)
    attempt.begin(session.emit)
    if attempt.action.drives_stay:
        trial = trial.reading
    try:
        trial.check_drives()
        found = attempt.action.do(step.path, trial)
        trial.check_drives()
        if trial.timeout_s is not None:
            trial.check_time()
    except PauseWantedError as wanted:
        attempt.end(notes.tell, found, ok=False)
        raise _unless_repeatable(step, wanted) from wanted
    except BaseException as error:
        session.put_messages()
        again, passed_over = _failed(attempt, error, notes)
        attempt.end(notes.tell, found, ok=False)
        if again or passed_over:
            return None if again else Done()
        raise
    attempt.end(session.emit, found, ok=True)
    if not (terms.limits or terms.expected):
        return Done(found.missed, step.leaves if found.leaves else 0)
    missed = session.judge(
        step.path,
        terms.limits,
        {**found.values, **found.statistics},
        expected=terms.expected,
        readings=found.readings,
    )
    return Done(missed if terms.stops_at_limit else "")


def _unless_repeatable(step: PlannedStep, wanted: PauseWantedError) -> Exception:
    """Return the pause, or the abort that it is inside a step that cannot be done twice."""
    if step.terms.repeatable:
        return PauseWantedError(wanted.message, wanted.by)
    text = f"{step.path}: {wanted.message}, inside a step that cannot be repeated"
    return AbortedError(text, by=wanted.by)


def _failed(attempt: Attempt, error: BaseException, notes: Notes) -> tuple[bool, bool]:
    """Put a failure on record; return whether it is tried again, and whether passed over."""
    path = attempt.step.path
    if notes.is_unkept(error):
        notes.note(path, error)
        return False, False
    again, passed_over = attempt.is_tried_again(error), attempt.is_passed_over(error)
    if again:
        attempts = attempt.step.terms.tries
        text = f"{words(error)}; try {attempt.number} of {attempts}"
        notes.tell(Alarm, source=path, text=text)
        notes.trace(error)
    elif passed_over:
        notes.pass_over(f"{path}: {words(error)}")
        notes.tell(Alarm, source=path, text=words(error) + GOES_ON)
        notes.trace(error)
    else:
        notes.note(path, error)
    return again, passed_over
