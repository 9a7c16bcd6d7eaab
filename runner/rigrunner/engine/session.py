"""What steps work with."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

from rigrunner.api.errors import AbortedError, DeviceTimeoutError

if TYPE_CHECKING:
    from rigrunner.api.devices import StopToken
    from rigrunner.api.events import Event
    from rigrunner.engine.answers import AnswerSource
    from rigrunner.rig import Rig


class Emit(Protocol):
    """Puts an event on the bus."""

    def __call__(self, kind: type[Event], **fields: Any) -> None:
        """Stamp and hand out an event of that kind."""
        ...


@dataclass(frozen=True)
class Session:
    """The rig, where events go, who answers, and whether to go on."""

    rig: Rig
    emit: Emit
    answers: AnswerSource
    stop: StopToken
    timeout_s: float | None = None
    """How long the present step may take."""
    began_s: float = 0.0
    """When the present step began, by the rig's clock."""

    def within(self, timeout_s: float | None) -> Session:
        """Return the session of a step that begins now and may take that long."""
        return replace(self, timeout_s=timeout_s, began_s=self.rig.clock.monotonic_s())

    def check(self) -> None:
        """Raise AbortedError if the run is asked to stop, DeviceTimeoutError if time is over."""
        check_stop(self.stop)
        self.check_time()

    def check_time(self) -> None:
        """Raise DeviceTimeoutError if the step has taken longer than it may."""
        taken_s = self.rig.clock.monotonic_s() - self.began_s
        if self.timeout_s is not None and taken_s > self.timeout_s:
            raise DeviceTimeoutError(
                f"the step is not done within {self.timeout_s:g} s", hint="see its timeout"
            )


def check_stop(stop: StopToken) -> None:
    """Raise AbortedError once the run is asked to stop."""
    if stop.is_set():
        raise AbortedError("stopped on request")
