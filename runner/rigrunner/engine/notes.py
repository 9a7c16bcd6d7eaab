"""Records what goes wrong in a run, and determines its outcome."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner.api.cleanup import error_text
from rigrunner.api.errors import (
    AbortedError,
    DeviceError,
    DeviceLostError,
    DeviceTimeoutError,
)
from rigrunner.api.events import Alarm, Intervention, Outcome
from rigrunner.engine.pausing import StopNow

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.devices import StopToken
    from rigrunner.api.events import Event
    from rigrunner.bus import Bus, Emit

CONTINUES = "; the run continues"
"""End of the text of an alarm for a failure after which the run continues."""


class Notes:
    """The first error determines how a run ends; later ones are recorded with it."""

    def __init__(
        self, bus: Bus, emit: Emit, stop: StopToken, passed_over: Iterable[str] = ()
    ) -> None:
        self._bus = bus
        self._emit = emit
        self._stop = stop
        self._errors: list[BaseException] = []
        self.first: BaseException | None = None
        """The first error."""
        self._passed_over = list(passed_over)
        self._unsafe: DeviceError | None = None
        self.stopped_at = ""
        """The values out of limits that stop the run, as text; '' for none."""

    @property
    def continues(self) -> bool:
        """Whether the run continues: no error, and no limit stops it."""
        return self.first is None and not self.stopped_at

    @property
    def last(self) -> BaseException | None:
        """The latest error."""
        return self._errors[-1] if self._errors else None

    @property
    def passed_over(self) -> tuple[str, ...]:
        """Failures and skips after which the run continued."""
        return tuple(self._passed_over)

    def try_emit(self, kind: type[Event], /, **fields: Any) -> None:
        """Emit an event without raising; a sink that fails is a further error."""
        try:
            self._emit(kind, **fields)
        except Exception as error:  # noqa: BLE001  (a failed sink gets no more events: this ends)
            self.note("event sink", error)

    def note(self, source: str, error: BaseException) -> None:
        """Record an error, once."""
        # Each level that it passes on its way out of the run may note it.
        if any(error is earlier for earlier in self._errors):
            return
        self.keep(error)
        # No alarm: a person or an interlock wanted the end.
        if isinstance(error, (AbortedError, KeyboardInterrupt)):
            self.try_emit(
                Intervention, action="abort", by=self._aborted_by(error), reason=error_line(error)
            )
        else:
            self.try_emit(Alarm, source=source, text=error_line(error))
            self.trace(error)

    def trace(self, error: BaseException) -> None:
        """Write the traceback of an error that was just recorded to run.log."""
        self._bus.trace(error)

    def keep(self, error: BaseException) -> None:
        """Let an error that is already recorded count for the outcome."""
        self._errors.append(error)
        self.first = self._errors[0]

    def left_unsafe(self, error: DeviceError) -> None:
        """End the run with an error, even if it has ended: a person must go to the rig."""
        self.keep(error)
        self._unsafe = error

    def prevents_recording(self, error: BaseException | None) -> bool:
        """Return whether an error means that the run cannot be recorded; no step is to blame."""
        return error is not None and error is self._bus.failure

    def may_be_resumed(self) -> bool:
        """Return whether the run may be resumed once its cause is fixed.

        True if it could not be recorded, or if a device was lost or did not answer, and no person
        ended it.
        """
        lost = isinstance(self.first, (DeviceLostError, DeviceTimeoutError))
        return lost or self.prevents_recording(self.first)

    def pass_over(self, text: str) -> None:
        """Let the run continue, and mention it at the end."""
        self._passed_over.append(text)

    def outcome(self) -> tuple[Outcome, str]:
        """Return the outcome of the run and the reason."""
        error = self.first
        if error is None:
            skipped = "; ".join(self._passed_over)
            passed_over = f"passed over: {skipped}" if self._passed_over else ""
            if self.stopped_at:
                reason = "; ".join(text for text in (self.stopped_at, passed_over) if text)
                return Outcome.STOPPED_AT_LIMIT, reason
            return Outcome.COMPLETED, passed_over
        reason = error_line(error)
        if self._unsafe is not None:
            also = "" if error is self._unsafe else f"; {error_line(self._unsafe)}"
            return Outcome.ERROR, reason + also
        aborted = isinstance(error, (AbortedError, KeyboardInterrupt))
        return Outcome.ABORTED if aborted else Outcome.ERROR, reason

    def _aborted_by(self, error: AbortedError | KeyboardInterrupt) -> str:
        by = _interrupt(error).by if isinstance(error, KeyboardInterrupt) else error.by
        return by or ("stop request" if self._stop.is_set() else "operator")


def error_line(error: BaseException) -> str:
    """Return an error as one line, with later failures of the cleanup."""
    if isinstance(error, KeyboardInterrupt):
        return "; ".join((_interrupt(error).reason, *getattr(error, "__notes__", ())))
    return error_text(error)


def _interrupt(error: KeyboardInterrupt) -> StopNow:
    """Return the interruption with who caused it and why; a plain one is Ctrl-C."""
    return error if isinstance(error, StopNow) else StopNow()
