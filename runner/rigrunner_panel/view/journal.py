"""What happened, in words, and what is wrong: bounded lists for the screen."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from rigrunner.api.events import Alarm, InterlockCleared, InterlockTripped, Intervention
from rigrunner.run.log import event_text
from rigrunner_panel.view.sections import AlarmView, LogLine

if TYPE_CHECKING:
    from rigrunner.api.events import Event

MOST = 100


class JournalView:
    """The latest events and alarms."""

    def __init__(self) -> None:
        self._log: deque[LogLine] = deque(maxlen=MOST)
        self._alarms: deque[AlarmView] = deque(maxlen=MOST)

    @property
    def log(self) -> tuple[LogLine, ...]:
        """The latest events in words, oldest first."""
        return tuple(self._log)

    @property
    def alarms(self) -> tuple[AlarmView, ...]:
        """The latest alarms, oldest first."""
        return tuple(self._alarms)

    def take(self, event: Event) -> None:
        """Take an event that a person may want to see."""
        text = event_text(event)
        if text:
            line = LogLine(seq=event.seq, utc=event.utc, kind=_kind(event), text=text)
            self._log.append(line)
        if isinstance(event, Alarm):
            active = isinstance(event, InterlockTripped)
            known = {"seq": event.seq, "utc": event.utc, "source": event.source}
            self._alarms.append(AlarmView(**known, text=event.text, active=active))
        elif isinstance(event, InterlockCleared):
            self._clear(f"interlock {event.interlock}")

    def _clear(self, source: str) -> None:
        cleared = (
            each.model_copy(update={"active": False}) if each.source == source else each
            for each in self._alarms
        )
        self._alarms = deque(list(cleared), maxlen=MOST)


def _kind(event: Event) -> str:
    """Return a word for the kind of event; of an intervention what was done."""
    if isinstance(event, Intervention):
        return event.action
    name = type(event).__name__
    return "".join(f"_{one.lower()}" if one.isupper() else one for one in name).lstrip("_")
