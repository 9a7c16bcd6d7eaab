"""Recorded and replayed pauses: when requested, how often interlocks were checked, the decision."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import AbortedError
from rigrunner.engine.pausing import Choice, Decision

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api.devices import Wire
    from rigrunner.engine import Paused, Pauses
    from rigrunner.tape.replaying import ReplayWire

_WANTED, _WATCH, _DECIDE = "is the run to pause?", "watch while paused", "what was decided"


class RecordedPauses:
    """Pauses that are recorded."""

    def __init__(self, pauses: Pauses, wire: Wire) -> None:
        self._pauses = pauses
        self._wire = wire

    def requested_by(self) -> str:
        """Return who requests a pause."""
        return self._wire.exchange(_WANTED, self._pauses.requested_by)

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:
        """Return the decision; each check of the interlocks until then is recorded.

        Its exceptions recur in a replay, as their readings are on tape.
        """
        raised: list[AbortedError] = []

        def recorded_watch() -> None:
            self._wire.exchange(_WATCH, lambda: None)
            try:
                watch()
            except AbortedError as error:
                raised.append(error)
                raise

        try:
            decision = self._pauses.decide(paused, recorded_watch)
        except AbortedError as error:
            if error not in raised:
                self._save(error)
            raise
        return _decision(self._wire.exchange(_DECIDE, lambda: asdict(decision)))

    def _save(self, error: AbortedError) -> None:
        def fail() -> None:
            raise error

        with suppress(AbortedError):
            self._wire.exchange(_DECIDE, fail)


class ReplayedPauses:
    """Pauses that are requested and end as recorded."""

    def __init__(self, wire: ReplayWire) -> None:
        self._wire = wire

    def requested_by(self) -> str:
        """Return who requested a pause."""
        return str(self._wire.reading(_WANTED) or "")

    def decide(self, paused: Paused, watch: Callable[[], None]) -> Decision:  # noqa: ARG002  (the engine's)
        """Return the decision, after as many checks of the interlocks."""
        while self._wire.is_next(_WATCH):
            self._wire.reading(_WATCH)
            watch()
        return _decision(self._wire.exchange(_DECIDE, dict))


def _decision(stored: dict[str, Any]) -> Decision:
    return Decision(Choice(stored["choice"]), str(stored["by"]), str(stored["reason"]))
