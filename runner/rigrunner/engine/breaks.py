"""Pauses: devices stand still if they can, and a person decides how the run continues."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import AbortedError, DeviceError
from rigrunner.api.events import Alarm, Note
from rigrunner.engine.pausing import Choice, Decision, Paused
from rigrunner.engine.points import may_be_skipped, point_at, point_name, unrepeatable
from rigrunner.plan.actions import Phase

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.engine.pausing import PauseRequestedError, Pauses
    from rigrunner.engine.session import Session
    from rigrunner.plan.actions import PlannedStep


def take_break(
    steps: Sequence[PlannedStep], index: int, request: PauseRequestedError, session: Session
) -> Decision:
    """Pause before a step and return how the run continues; raise AbortedError if it does not.

    Interlocks are monitored meanwhile. Without a person to decide, the run is aborted.
    """
    # Also if no one can resume: the record says why the run was aborted.
    session.intervene("pause", request.by, request.message)
    if session.pauses is None:
        raise AbortedError(f"{request.message}; there is nobody to resume it", by=request.by)
    moving = tuple(session.rig.pause())
    for text in moving:
        session.emit(Alarm, source="pause", text=text)
    pause = _Pause(steps, index, session)
    decision = pause.decision(session.pauses, request.message, moving)
    if decision.choice is Choice.ABORT:
        reason = f": {decision.reason}" if decision.reason else ""
        raise AbortedError(f"{pause.path}: aborted while paused{reason}", by=decision.by)
    # Recorded before anything moves again.
    session.intervene(str(decision.choice), decision.by, pause.reason(decision))
    session.rig.resume()
    return decision


@dataclass(frozen=True, eq=False)
class _Pause:
    """A pause, before or inside a step."""

    steps: Sequence[PlannedStep]
    index: int
    session: Session

    @property
    def path(self) -> str:
        return self.steps[self.index].path

    @property
    def point(self) -> str:
        return point_name(self.steps, self.index)

    def decision(self, pauses: Pauses, reason: str, moving: tuple[str, ...]) -> Decision:
        """Ask until the run can continue as chosen, or is to end."""
        guard, why = self.session.guard, reason
        while True:
            # New each time: an interlock can trip or clear while the person decides.
            choices = tuple(self._choices())
            paused = Paused(self.path, self.point, why, moving, choices)
            # The guardian must not mistake waiting for a person for a hang.
            with self.session.rig.person():
                decision = pauses.decide(paused, self.session.watch)
            match decision.choice:
                case Choice.ABORT:
                    return decision
                case Choice.NOTE:
                    text = f"{decision.by}: {decision.reason}"
                    self.session.emit(Note, step=self.path, text=text)
                case Choice.OVERRIDE if Choice.OVERRIDE in choices:
                    guard.override()
                    return decision
                case choice if choice in choices and not guard.pausing():
                    return decision
                # Not offered, or an interlock that is still tripped: the person is asked again.
                case _:
                    why = f"{guard.pausing()}; not cleared yet" if guard.pausing() else reason

    def reason(self, decision: Decision) -> str:
        """Return the reason that is recorded with the choice."""
        if decision.choice not in (Choice.REPEAT, Choice.SKIP):
            return decision.reason
        return f"{self.point}: {decision.reason}" if decision.reason else self.point

    def _may_be_skipped(self) -> bool:
        try:
            return may_be_skipped(self.steps, self.index, self.session.rig.standing)
        except DeviceError:  # the position of a drive is not known
            return False

    def _choices(self) -> Iterator[Choice]:
        yield Choice.RESUME
        if self.session.guard.may_be_overridden():
            yield Choice.OVERRIDE
        # The paused step itself does not count: it has not begun, or may be repeated.
        if not unrepeatable(self.steps, range(point_at(self.steps, self.index).start, self.index)):
            yield Choice.REPEAT
        if self.steps[self.index].phase is Phase.MAIN and self._may_be_skipped():
            yield Choice.SKIP
        yield Choice.NOTE
        yield Choice.ABORT
