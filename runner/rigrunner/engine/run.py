"""The way of a run: setup, main, teardown always, safe always, and an honest end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import AbortedError, DeviceError, RigrunnerError
from rigrunner.api.events import (
    Alarm,
    Event,
    Intervention,
    Outcome,
    RunEnded,
    RunStarted,
    StepEnded,
    StepStarted,
)
from rigrunner.bus import Emitter
from rigrunner.engine.steps import Measured, Session, action_name, perform
from rigrunner.engine.streams import check_stop
from rigrunner.plan.actions import Measure, Phase, Record

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.bus import Bus
    from rigrunner.engine.answers import AnswerSource
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


def run_plan(  # noqa: PLR0917  (the seven things that a run is made of)
    plan: Plan,
    rig: Rig,
    bus: Bus,
    clock: Clock,
    answers: AnswerSource,
    stop: StopToken,
    run_id: str,
) -> RunSummary:
    """Run a plan on a connected rig and return how it ended; never raises for what steps raise.

    Whatever happens, Ctrl-C and the failure of a critical sink included: every teardown step is
    tried, and then the rig is made safe. Connecting and closing the rig is the caller's.
    """
    run = _Run(plan, Session(rig, Emitter(bus, clock), answers, stop))
    reports: tuple[SafetyReport, ...] = ()
    try:
        run.attempt(partial(run.setup_and_main, run_id))
        run.teardown()
    except BaseException as error:  # noqa: BLE001  (an interrupt that fell between two steps)
        run.note("run", error)
    finally:
        reports = rig.make_safe()
    return run.end(reports)


class _Run:
    """One run in progress; the first error decides its outcome, the others are put on record."""

    def __init__(self, plan: Plan, session: Session) -> None:
        self._plan = plan
        self._session = session
        self._emit = session.emit
        self._noted: list[BaseException] = []

    def setup_and_main(self, run_id: str) -> None:
        steps, seconds = self._plan.steps, self._plan.estimated_s
        self._emit(RunStarted, run_id=run_id, steps=len(steps), estimated_s=seconds)
        for index, step in enumerate(steps):
            if step.phase is not Phase.TEARDOWN:
                check_stop(self._session.stop)
                self._step(index, step, self._session)

    def teardown(self) -> None:
        undisturbed = replace(self._session, emit=self._tell, stop=_Never())
        for index, step in enumerate(self._plan.steps):
            if step.phase is Phase.TEARDOWN:
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
        return RunSummary(*self._outcome(), self._first(), not unsafe)

    def _step(self, index: int, step: PlannedStep, session: Session) -> None:
        action, name = step.action, action_name(step.action)
        recording = action.name if isinstance(action, Record) else ""
        measurement = action.name if isinstance(action, Measure) else ""
        known: dict[str, Any] = {
            "step": step.path,
            "index": index,
            "action": name,
            "recording": recording,
        }
        setpoints = action.setpoints if isinstance(action, (Record, Measure)) else {}
        units = action.units if isinstance(action, (Record, Measure)) else {}
        session.emit(StepStarted, **known, text=step.text, setpoints=setpoints, units=units)
        known |= {"measurement": measurement, "setpoints": setpoints if measurement else {}}
        try:
            measured = perform(step.path, action, session)
        except BaseException as error:
            self.note(step.path, error)
            self._tell(StepEnded, **known, ok=False)
            raise
        session.emit(StepEnded, **known, ok=True, **_fields(measured))

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


def _fields(measured: Measured) -> dict[str, object]:
    return {"values": measured.values, "units": measured.units, "truth": measured.truth}


def _words(error: BaseException) -> str:
    if isinstance(error, KeyboardInterrupt):
        return "interrupted from the keyboard"
    return str(error) if isinstance(error, RigrunnerError) else f"{type(error).__name__}: {error}"
