"""Manual mode: a run without a plan; a person gives its steps one by one."""

from __future__ import annotations

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError
from rigrunner.bus import Emitter
from rigrunner.engine.answers import UnattendedAnswers
from rigrunner.engine.interlocks import Guard
from rigrunner.engine.notes import Notes
from rigrunner.engine.pausing import PauseRequestedError
from rigrunner.engine.run import Run
from rigrunner.engine.session import Session
from rigrunner.engine.step_attempts import do_step
from rigrunner.plan.actions import Plan

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api.devices import Clock, StopToken
    from rigrunner.bus import Bus
    from rigrunner.engine.pausing import Interference, Override, Pauses
    from rigrunner.engine.run import RunSummary
    from rigrunner.plan.actions import Interlock, PlannedStep
    from rigrunner.rig import Rig, SafetyReport

    Steps = Callable[[Session], Iterator[PlannedStep]]


def run_by_hand(  # noqa: PLR0917  (the things that a run is made of)
    steps: Steps,
    rig: Rig,
    bus: Bus,
    clock: Clock,
    stop: StopToken,
    run_id: str,
    overrides: Sequence[Override] = (),
    *,
    interlocks: Sequence[Interlock],
    pauses: Pauses,
    before: Sequence[Interference] = (),
) -> RunSummary:
    """Execute steps as they come, on a connected rig, and return how it ended; never raises.

    `steps` is called with the session, to read the rig between steps. A failure is recorded and
    ends the run unless the terms of the step say otherwise; so does an interlock that would pause a
    run. The rig is always made safe at the end. Events `before` it are recorded too.
    """
    emit = Emitter(bus, clock)
    session = Session(rig, emit, UnattendedAnswers(), stop, Guard(interlocks, rig, emit), pauses)
    notes = Notes(bus, emit, stop)
    run = _ByHand(Plan((), tuple(interlocks)), session, notes, overrides, before=before)
    reports: tuple[SafetyReport, ...] = ()
    try:
        run.attempt(partial(run.follow, steps, run_id))
    except BaseException as error:  # noqa: BLE001  (an interrupt that fell between two steps)
        run.notes.note("run", error)
    finally:
        reports = run.make_safe()
    return run.end(reports)


class _ByHand(Run):
    """A run whose steps come one by one."""

    def follow(self, steps: Steps, run_id: str) -> None:
        """Execute each step as it comes."""
        self._begin(run_id)
        attempts: Counter[int] = Counter()
        try:
            for index, step in enumerate(steps(self._session)):
                self._session.check(read_all=True)
                done = do_step(index, step, self._session, self.notes, attempts)
                self.notes.stopped_at = done.missed
                if self.notes.stopped_at:
                    break
        except PauseRequestedError as request:
            raise AbortedError(request.message, by=request.by) from request
