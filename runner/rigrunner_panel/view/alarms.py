"""Alarms on the screen: the latest of a run, and rigs that were left energised."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from rigrunner.api.events import Alarm, InterlockCleared, InterlockTripped, RunEnded
from rigrunner.rig_state import read_markers
from rigrunner_panel.view.sections import AlarmView

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.api.events import Event

MOST = 100


def alarms_of_rigs(concerns: Callable[[str], bool]) -> tuple[AlarmView, ...]:
    """Return an alarm for each rig that was left energised and is not in use.

    `concerns` selects stations by id. An alarm is active until a read-back shows the rig is safe.
    """
    return tuple(
        AlarmView(
            seq=-1,
            utc=marker.owner.since if marker.owner else "",
            source="rig",
            text=marker.text,
            active=not marker.safe_by,
        )
        for marker in read_markers()
        if concerns(marker.station) and not marker.is_in_use
    )


class Alarms:
    """The latest alarms of a job, and rigs of this machine that were left energised."""

    def __init__(self, rigs: tuple[AlarmView, ...] = ()) -> None:
        self.rigs = rigs
        self._of_run: deque[AlarmView] = deque(maxlen=MOST)

    @property
    def all(self) -> tuple[AlarmView, ...]:
        """Those of rigs, then those of the job, oldest first."""
        return (*self.rigs, *self._of_run)

    def take(self, event: Event) -> None:
        """Add or clear an alarm, if the event is one; ignore other events."""
        if isinstance(event, Alarm):
            active = isinstance(event, InterlockTripped)
            known = {"seq": event.seq, "utc": event.utc, "source": event.source}
            self._of_run.append(AlarmView(**known, text=event.text, active=active))
        elif isinstance(event, InterlockCleared):
            cleared = f"interlock {event.interlock}"
            self._update(lambda each: each.source == cleared, {"active": False})
        elif isinstance(event, RunEnded):  # the interlocks are not monitored any more
            self._update(lambda each: each.active, {"active": False, "until_end": True})

    def _update(self, which: Callable[[AlarmView], bool], update: Mapping[str, bool]) -> None:
        alarms = (each.model_copy(update=update) if which(each) else each for each in self._of_run)
        self._of_run = deque(list(alarms), maxlen=MOST)
