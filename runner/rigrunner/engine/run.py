"""The way of a run: setup, main, teardown always, safe always, and an honest end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, DeviceError, RigrunnerError
from rigrunner.api.events import (
    Alarm,
    Event,
    Intervention,
    Note,
    Outcome,
    RunEnded,
    RunStarted,
    StepEnded,
    StepStarted,
)
from rigrunner.bus import Emitter
from rigrunner.engine.attempt import Attempt
from rigrunner.engine.limits import judge
from rigrunner.engine.session import Session, check_stop
from rigrunner.engine.steps import Measured, perform
from rigrunner.plan.actions import Phase

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.bus import Bus
    from rigrunner.engine.answers import AnswerSource
    from rigrunner.engine.overrides import Override
    from rigrunner.plan.actions import Plan, PlannedStep
    from rigrunner.rig import Rig, SafetyReport


@dataclass(frozen=True)
class RunSummary:
    """How a run ended. Only `completed` is a success, and only where the rig is safe."""

    outcome: Outcome
    reason: str
    error: BaseException | None
    """The first error; what is no RigrunnerError or KeyboardInterrupt is a bug to be shown."""
    safe: bool
    passed_over: tuple[str, ...] = ()
    """The failures after which the run went on because the procedure says so."""


def run_plan(  # noqa: PLR0917  (the things that a run is made of)
    plan: Plan,
    rig: Rig,
    bus: Bus,
    clock: Clock,
    answers: AnswerSource,
    stop: StopToken,
    run_id: str,
    overrides: Sequence[Override] = (),
) -> RunSummary:
    """Run a plan on a connected rig and return how it ended; never raises for what steps raise.

    Whatever happens, Ctrl-C and the failure of a critical sink included: every teardown step is
    tried, and then the rig is made safe. Connecting and closing the rig is the caller's.
    """
    run = _Run(plan, Session(rig, Emitter(bus, clock), answers, stop), overrides)
    reports: tuple[SafetyReport, ...] = ()
    try:
        run.attempt(partial(run.forward, run_id))
        run.teardown()
    except BaseException as error:  # noqa: BLE001  (an interrupt that fell between two steps)
        run.note("run", error)
    finally:
        reports = rig.make_safe()
    return run.end(reports)


class _Run:
    """One run in progress; the first error decides its outcome, the others are put on record."""

    def __init__(self, plan: Plan, session: Session, overrides: Sequence[Override]) -> None:
        self._plan = plan
        self._overrides = overrides
        self._session = session
        self._emit = session.emit
        self._noted: list[BaseException] = []
        self._passed_over: list[str] = []
        self._begun = -1

    def forward(self, run_id: str) -> None:
        """Do all steps up to the teardown, those of called procedures included."""
        steps, seconds = self._plan.steps, self._plan.estimated_s
        self._emit(RunStarted, run_id=run_id, steps=len(steps), estimated_s=seconds)
        for each in self._overrides:
            told = {"by": each.by, "reason": each.reason, "subject": each.subject}
            self._emit(Intervention, action="override", **told)
        for index, step in enumerate(steps):
            if self._noted or (step.phase is Phase.TEARDOWN and not step.calls):
                return
            if step.phase is Phase.TEARDOWN:
                self._tear_down(index, step)
                continue
            check_stop(self._session.stop)
            self._begun = index
            self._step(index, step, self._session)

    def teardown(self) -> None:
        """Do what is left of the teardowns: of the calls that the run is in, and its own."""
        begun = self._begun
        within = self._plan.steps[begun].calls if begun >= 0 else ()
        for index, step in enumerate(self._plan.steps):
            entered = step.calls == within[: len(step.calls)]
            if index > begun and step.phase is Phase.TEARDOWN and entered:
                self._tear_down(index, step)

    def _tear_down(self, index: int, step: PlannedStep) -> None:
        """Do one step of a teardown; nothing keeps the next one from its turn."""
        self._begun = index
        undisturbed = replace(self._session, emit=self._tell, stop=_Never())
        self.attempt(partial(self._step, index, step, undisturbed))

    def attempt(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:  # noqa: BLE001  (kept; what follows must make the rig safe)
            self.note("run", error)

    def note(self, source: str, error: BaseException) -> None:
        """Put an error on record, once."""
        if any(error is noted for noted in self._noted):
            return
        self._noted.append(error)
        if isinstance(error, (AbortedError, KeyboardInterrupt)):
            self._tell(Intervention, action="abort", by=self._who(error), reason=_words(error))
        else:
            self._tell(Alarm, source=source, text=_words(error))

    def end(self, reports: tuple[SafetyReport, ...]) -> RunSummary:
        unsafe = [f"{report.role}: {text}" for report in reports for text in report.problems]
        for text in unsafe:
            self._tell(Alarm, source="make safe", text=text)
        if unsafe:
            self._noted.append(DeviceError("the rig is not safe: " + "; ".join(unsafe)))
        read_back = {
            f"{report.role}.{drive}": value
            for report in reports
            for drive, value in report.read_back.items()
        }
        outcome, reason = self._outcome()
        self._tell(RunEnded, outcome=outcome, reason=reason, read_back=read_back)
        passed_over = tuple(self._passed_over)
        return RunSummary(*self._outcome(), self._first(), not unsafe, passed_over)

    def _step(self, index: int, step: PlannedStep, session: Session) -> None:
        """Do one step, and again after a failure for as long as its terms allow."""
        for number in range(1, step.terms.tries + 1):
            if self._try(Attempt(index, step, number), session):
                return

    def _try(self, attempt: Attempt, session: Session) -> bool:
        """Return whether the step is over; raise what ends the run."""
        step, found = attempt.step, Measured()
        trial = session.within(step.terms.timeout_s)
        session.emit(StepStarted, **attempt.started)
        try:
            found = perform(step.path, attempt.action, trial)
            trial.check_time()
            remarks = judge(step.terms.limits, found.values)
        except BaseException as error:
            again, passed_over = self._failed(attempt, error)
            self._tell(StepEnded, **attempt.ended, ok=False, **_values(found))
            if again or passed_over:
                return not again
            raise
        for text in remarks:
            session.emit(Note, step=step.path, text=text)
        session.emit(StepEnded, **attempt.ended, ok=True, **_values(found), truth=found.truth)
        return True

    def _failed(self, attempt: Attempt, error: BaseException) -> tuple[bool, bool]:
        """Put a failure on record; return whether it is tried again, and whether passed over."""
        path, words = attempt.step.path, _words(error)
        again, passed_over = attempt.is_tried_again(error), attempt.is_passed_over(error)
        if again:
            tries = attempt.step.terms.tries
            self._tell(Alarm, source=path, text=f"{words}; try {attempt.number} of {tries}")
        elif passed_over:
            self._passed_over.append(f"{path}: {words}")
            self._tell(Alarm, source=path, text=f"{words}; the run goes on")
        else:
            self.note(path, error)
        return again, passed_over

    def _tell(self, kind: type[Event], **fields: object) -> None:
        """Emit what must not raise: a sink that fails now is an error beside the first."""
        try:
            self._emit(kind, **fields)
        except Exception as error:  # noqa: BLE001  (a failed sink gets no more events: this ends)
            self.note("event sink", error)

    def _who(self, error: BaseException) -> str:
        if isinstance(error, KeyboardInterrupt):
            return "keyboard"
        return "stop request" if self._session.stop.is_set() else "operator"

    def _outcome(self) -> tuple[Outcome, str]:
        error = self._first()
        if error is None and self._passed_over:
            return Outcome.COMPLETED, f"passed over: {'; '.join(self._passed_over)}"
        if error is None:
            return Outcome.COMPLETED, ""
        aborted = isinstance(error, (AbortedError, KeyboardInterrupt))
        return Outcome.ABORTED if aborted else Outcome.ERROR, _words(error)

    def _first(self) -> BaseException | None:
        return next(iter(self._noted), None)


class _Never:
    """The stop token of the teardown: a run that was asked to stop still ends in order."""

    def is_set(self) -> bool:
        return False


def _values(found: Measured) -> dict[str, object]:
    return {"values": found.values, "units": found.units}


def _words(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return "interrupted from the keyboard"
    return str(error) if isinstance(error, RigrunnerError) else f"{type(error).__name__}: {error}"
