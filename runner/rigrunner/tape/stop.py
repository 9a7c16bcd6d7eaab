"""Recorded and replayed stop tokens: a replay stops at the same place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import AbortedError, ExitCode
from rigrunner.engine.pausing import Interrupting, Reasoned

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import StopToken, Wire
    from rigrunner.tape.replaying import ReplayWire

_IS_SET, _REASON = "is the run to stop?", "why it is to stop"


class _OnTape:
    """A token on tape, and the plain one behind it."""

    def __init__(self, plain: StopToken) -> None:
        self.plain = plain

    def stop_interrupting(self) -> None:
        """Stop the plain token from interrupting."""
        if isinstance(self.plain, Interrupting):
            self.plain.stop_interrupting()


class RecordedStop(_OnTape):
    """A stop token whose readings are recorded."""

    def __init__(self, plain: StopToken, wire: Wire) -> None:
        super().__init__(plain)
        self._wire = wire

    def is_set(self) -> bool:
        """Return True once the run has to stop."""
        return self._wire.exchange(_IS_SET, lambda: bool(self.plain.is_set()))

    def reason(self) -> AbortedError:
        """Return the reason for stopping."""
        return _error(self._wire.exchange(_REASON, lambda: _reason_fields(self.plain)))


class ReplayedStop(_OnTape):
    """A stop token that is set as recorded, and whenever the replay is stopped.

    It never raises, like the clock of a replay.
    """

    def __init__(self, plain: StopToken, wire: ReplayWire) -> None:
        super().__init__(plain)
        self._wire = wire
        self._was_set = False

    def is_set(self) -> bool:
        """Return True once the run had to stop, or the replay has to."""
        self._was_set = self._wire.reading(_IS_SET) is True
        return self._was_set or self.plain.is_set()

    def reason(self) -> AbortedError:
        """Return the reason for stopping."""
        # On tape there is a reason only where the run was stopped, not the replay.
        stored = self._wire.reading(_REASON) if self._was_set else None
        return _error(stored if isinstance(stored, dict) else _reason_fields(self.plain))


def plain_stop(stop: StopToken) -> StopToken:
    """Return the plain token behind one on tape."""
    return stop.plain if isinstance(stop, _OnTape) else stop


def _reason_fields(stop: StopToken) -> dict[str, Any]:
    reason = stop.reason() if isinstance(stop, Reasoned) else AbortedError("stopped on request")
    texts = {"message": reason.message, "hint": reason.hint, "by": reason.by}
    return {**texts, "exit_code": int(reason.exit_code)}


def _error(stored: Mapping[str, Any]) -> AbortedError:
    error = AbortedError(str(stored["message"]), hint=str(stored["hint"]), by=str(stored["by"]))
    error.exit_code = ExitCode(stored["exit_code"])
    return error
