"""The sequence of a run: setup, main, always teardown, always make safe, and a true outcome."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, DeviceError
from rigrunner.api.events import (
    RESUME_RUN,
    Alarm,
    MadeSafe,
    RunEnded,
    RunStarted,
)
from rigrunner.api.steps import NONE
from rigrunner.bus import Emitter
from rigrunner.engine.breaks import take_break
from rigrunner.engine.drive_watch import DriveWatch
from rigrunner.engine.interlocks import Guard, InterlockError
from rigrunner.engine.notes import Notes
from rigrunner.engine.pausing import Choice, Interrupting, PauseRequestedError, StopNow
from rigrunner.engine.points import point_at, point_name, settles_before, teardowns_within
from rigrunner.engine.resume_point import restoring_step
from rigrunner.engine.session import Session
from rigrunner.engine.step_attempts import Done, do_step
from rigrunner.plan.actions import Phase
from rigrunner.rig import problems_text, unsafe_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.api.events import Outcome
    from rigrunner.api.quantity import Estimate
    from rigrunner.bus import Bus
    from rigrunner.engine.answers import AnswerSource
    from rigrunner.engine.pausing import Decision, Interference, Override, Pauses
    from rigrunner.engine.resume_point import ResumePoint
    from rigrunner.plan.actions import Plan, PlannedStep
    from rigrunner.rig import Rig, SafetyReport

_TEARDOWN = Phase.TEARDOWN
"""In Python 3.11 the lookup of a member of an enumeration takes as long as a call."""


@dataclass(frozen=True)
class RunSummary:
    """How a run ended.

    Only `completed` and `stopped at a limit`, with a safe rig, are successes of the runner.
    """

    outcome: Outcome
    reason: str
    error: BaseException | None
    """The first error; other than RigrunnerError or KeyboardInterrupt it is a bug, to be displayed.
    """
    unsafe: str = ""
    """Why the rig is not known to be safe, as text."""
    passed_over: tuple[str, ...] = ()
    """Failures and skips after which the run continued, by procedure or person."""
    resumable: bool = False
    """Whether it may be resumed once its cause is fixed, as in `RunEnded`."""

    @property
    def safe(self) -> bool:
        """Whether the rig was left safe."""
        return not self.unsafe


def run_plan(  # noqa: PLR0917  (the things that a run is made of)
    plan: Plan,
    rig: Rig,
    bus: Bus,
    clock: Clock,
    answers: AnswerSource,
    stop: StopToken,
    run_id: str,
    overrides: Sequence[Override] = (),
    *,
    pauses: Pauses | None = None,
    resume_at: ResumePoint | None = None,
    before: Sequence[Interference] = (),
    watches_drives: bool = True,
    inputs: Mapping[str, str] = NONE,
    results: Callable[[str], Estimate] | None = None,
) -> RunSummary:
    """Run a plan on a connected rig and return how it ended; never raises for errors of steps.

    In every case, Ctrl-C and the failure of a critical sink included, every teardown step is tried,
    and then the rig is made safe. Only `StopNow` skips the teardown. Without `pauses` a request for
    a pause aborts the run. With `resume_at` an interrupted run is resumed. Events `before` it are
    recorded with its start. `watches_drives`: drives are read back during readings; not in the
    replay of a tape without read-backs. `inputs` are the answers for conditions, and `results`
    calculates a result for them. The caller connects and closes the rig.
    """
    emit = Emitter(bus, clock, 0 if resume_at is None else resume_at.next_seq)
    guard = Guard(plan.interlocks, rig, emit)
    drives = DriveWatch(rig, emit) if watches_drives else None
    session = Session(
        rig, emit, answers, stop, guard, pauses, drives=drives, inputs=dict(inputs), results=results
    )
    notes = Notes(bus, emit, stop, resume_at.passed_over if resume_at else ())
    run = Run(plan, session, notes, overrides, resume_at, before=before)
    reports: tuple[SafetyReport, ...] = ()
    try:
        run.attempt(partial(run.forward, run_id))
        run.teardown()
    except BaseException as error:  # noqa: BLE001  (an interrupt that fell between two steps)
        run.notes.note("run", error)
    finally:
        reports = run.make_safe()
    return run.end(reports)


class Run:
    """A run in progress: its parts, in the order in which it needs them."""

    def __init__(
        self,
        plan: Plan,
        session: Session,
        notes: Notes,
        overrides: Sequence[Override],
        resume_at: ResumePoint | None = None,
        *,
        before: Sequence[Interference] = (),
    ) -> None:
        self._plan = plan
        self._before = before
        self._overrides = overrides
        self._resume_at = resume_at
        self._session = session
        self.notes = notes
        self._attempts = Counter[int](resume_at.attempts if resume_at else {})
        # The latest step in the order of the plan; its calls are those whose teardown is due.
        self._latest = -1

    def forward(self, run_id: str) -> None:
        """Execute all steps up to the teardown, those of called procedures included."""
        steps, counts_cycles = self._plan.steps, False
        index = (
            self._begin(run_id)
            if self._resume_at is None
            else self._resume(run_id, self._resume_at)
        )
        # A run that continues after an interruption or a pause settles again before it measures.
        settles = settles_before(steps, index) if index < len(steps) else []
        while index < len(steps) and self.notes.continues:
            step = steps[index]
            if step.phase is _TEARDOWN:
                if not step.calls:  # that of the procedure itself: `teardown` does it in any case
                    break
                self.notes.stopped_at = self._tear_down(index, step)
                index += 1
                continue
            if not counts_cycles and step.phase is Phase.MAIN:
                counts_cycles = True
                self._session.rig.cycles.start_from(
                    self._resume_at.cycles if self._resume_at else {}
                )
            try:
                # With the progress of `index`: a failure while it settles tears down its calls.
                for settle in settles:
                    self._execute(settle, at=index)
                settles = []
                done = self._execute(index, at=index)
                self.notes.stopped_at = done.missed
                index += 1 + done.leaves  # a condition leaves out the steps of its other branch
            except PauseRequestedError as request:
                # The step has not been done: unless a person decides otherwise, it is next again.
                decision = take_break(steps, index, request, self._session)
                index = self._next(index, decision)
                settles = settles_before(steps, index) if index < len(steps) else []
        if self.notes.first is None:
            self._session.watch(read_all=True)  # what came up in the last step must not pass unseen

    def teardown(self) -> None:
        """Execute the remaining teardowns: of the calls that the run is in, and its own."""
        steps = self._plan.steps
        for index, step in teardowns_within(steps, self._latest, range(len(steps))):
            # The last error, not the first: a person may also request it during the teardown.
            if isinstance(self.notes.last, StopNow):
                return
            self._tear_down(index, step)

    def attempt(self, work: Callable[[], Done | None]) -> str:
        """Call a function whose failure must not prevent making the rig safe.

        Return the values out of limits that it reports, as text; '' for none.
        """
        try:
            return (work() or Done()).missed
        except InterlockError as error:
            self.notes.note("run", error)
            if error.makes_safe:
                # Now, and again at the end: the teardown that follows sets drives.
                self._record_safe(self._session.rig.make_safe())
        except BaseException as error:  # noqa: BLE001  (kept; what follows must make the rig safe)
            self.notes.note("run", error)
        return ""

    def make_safe(self) -> tuple[SafetyReport, ...]:
        """Make the rig safe; cannot be interrupted, and exceptions are recorded."""
        rig, stop = self._session.rig, self._session.stop
        try:
            # Inside the `try`: an interrupt may still come in here.
            if isinstance(stop, Interrupting):
                stop.stop_interrupting()
            return rig.make_safe()
        except BaseException as error:  # noqa: BLE001  (kept; the rig is made safe first)
            # A second Ctrl-C may fall into the first attempt. Making safe twice does no harm.
            self.notes.note("run", error)
            return rig.make_safe()

    def end(self, reports: tuple[SafetyReport, ...]) -> RunSummary:
        """Record how the rig was left and how the run ended."""
        # The end must be recorded whole even if a sink fails on one of its events.
        replace(self._session, emit=self.notes.try_emit).put_messages()
        self._record_safe(reports)
        unsafe = unsafe_text(reports)
        if unsafe:
            self.notes.left_unsafe(DeviceError(f"the rig is not safe: {unsafe}"))
        # Only in a replay: there is no rig to go to, but the difference from the tape is an error.
        elif out_of_step := problems_text(reports):
            self.notes.keep(DeviceError(out_of_step))
        read_back: dict[str, float] = {}
        units: dict[str, str] = {}
        for report in reports:
            read_back |= report.by_member(report.read_back)
            units |= report.by_member(report.units)
        outcome, reason = self.notes.outcome()
        # A manual session has no plan to resume.
        resumable = bool(self._plan.steps) and self.notes.may_be_resumed()
        # The sink that records this event may fail too, so the outcome is determined again below.
        self.notes.try_emit(
            RunEnded,
            outcome=outcome,
            reason=reason,
            read_back=read_back,
            units=units,
            resumable=resumable,
        )
        passed_over = self.notes.passed_over
        outcome, reason = self.notes.outcome()
        return RunSummary(outcome, reason, self.notes.first, unsafe, passed_over, resumable)

    def _begin(self, run_id: str) -> int:
        """Record the start and return the first step."""
        self._record_start(run_id, self._plan.steps)
        for override in self._overrides:
            self._session.intervene("override", override.by, override.reason, override.subject)
        return 0

    def _resume(self, run_id: str, resume_at: ResumePoint) -> int:
        """Restore the state of the rig for a resumed run, and return the step to continue at.

        Nothing is skipped here: without its zero and its drives the rest would not be comparable.
        """
        before = [restoring_step(self._plan.steps[index]) for index in resume_at.before]
        self._record_start(run_id, (*before, *self._plan.steps[resume_at.start :]))
        self._session.intervene(RESUME_RUN, resume_at.by, subject=resume_at.subject)
        # A pause would leave the rig between two states: it has to wait, and aborts a question.
        unpaused = replace(self._session, pauses=None)
        for index, step in zip(resume_at.before, before, strict=True):
            try:
                unpaused.check(read_all=True)
                self._latest = index
                done = do_step(index, step, unpaused, self.notes, self._attempts)
                if done.missed:
                    self.notes.stopped_at = done.missed
                    break
            except PauseRequestedError as request:
                text = f"{request.message}, while the run was being resumed"
                raise AbortedError(text, by=request.by) from request
        return resume_at.start

    def _record_start(self, run_id: str, to_do: Iterable[PlannedStep]) -> None:
        """Announce that these steps begin, and their duration."""
        count, seconds = len(self._plan.steps), sum(step.estimated_s for step in to_do)
        self._session.emit(RunStarted, run_id=run_id, steps=count, estimated_s=seconds)
        self._session.show()
        for past in self._before:
            self._session.intervene(past.action, past.by, past.reason, past.subject)

    def _execute(self, index: int, at: int) -> Done:
        """Execute a forward step; `at` is the progress of the run. Return as `do_step`."""
        self._session.check(read_all=True)
        # After the check: a step that an interlock keeps from beginning has not begun.
        self._latest = at
        return do_step(index, self._plan.steps[index], self._session, self.notes, self._attempts)

    def _next(self, index: int, decision: Decision) -> int:
        """Return the step that follows a decision."""
        steps = self._plan.steps
        point = point_at(steps, index)
        if decision.choice not in (Choice.REPEAT, Choice.SKIP):
            return index
        for at, step in teardowns_within(steps, self._latest, range(index, point.stop)):
            if missed := self._tear_down(at, step):
                self.notes.stopped_at = missed
        if decision.choice is Choice.REPEAT:
            return point.start
        name = point_name(steps, index)
        self.notes.pass_over(f"{name}: skipped by {decision.by}: {decision.reason}")
        return point.stop

    def _tear_down(self, index: int, step: PlannedStep) -> str:
        """Execute one step of a teardown; its failure does not skip the next one.

        Return as `attempt`: the teardown of a called procedure can stop the continuing run.
        """
        self._latest = index
        session = replace(self._session.ending(), emit=self.notes.try_emit)
        return self.attempt(partial(do_step, index, step, session, self.notes, self._attempts))

    def _record_safe(self, reports: tuple[SafetyReport, ...]) -> None:
        """Record how each drive and device was made safe, in order."""
        for report in reports:
            for text in report.problems:
                self.notes.try_emit(Alarm, source="make safe", text=f"{report.role}: {text}")
            self.notes.try_emit(
                MadeSafe,
                what=report.what,
                read_back=report.by_member(report.read_back),
                units=report.by_member(report.units),
                problems=report.problems,
            )
