"""Alarms on the screen: the latest of a run, and rigs that were left energised."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError
from rigrunner.api.events import Alarm, InterlockCleared, InterlockTripped, RunEnded
from rigrunner.rig_state import read_markers
from rigrunner_panel.view.sections import AlarmView

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.api.events import Event

    Alarms = tuple[AlarmView, ...]

MOST = 100
OF_RIG = -1
"""The number of an alarm of a rig: those of a job have that of their event."""


def alarms_of_rigs(concerns: Callable[[str], bool]) -> tuple[AlarmView, ...]:
    """Return an alarm for each rig that was left energised and is not in use.

    `concerns` selects stations by id. An alarm is active until a read-back shows the rig is safe.
    """
    try:
        markers = read_markers()
    except DeviceError as error:
        return (AlarmView(seq=OF_RIG, utc="", source="rig", text=error.message, active=True),)
    return tuple(
        AlarmView(
            seq=OF_RIG,
            utc=marker.owner.since if marker.owner else "",
            source="rig",
            text=marker.text,
            active=not marker.safe_by,
        )
        for marker in markers
        if concerns(marker.station) and not marker.is_in_use
    )


def with_rigs(alarms: Alarms, rigs: Alarms) -> Alarms:
    """Return the alarms of rigs that were left energised, then those of the job."""
    return (*rigs, *(alarm for alarm in alarms if not _is_of_rig(alarm)))


def alarms_after(alarms: Alarms, event: Event) -> Alarms:
    """Return the alarms after an event, of a job the latest, oldest first."""
    if isinstance(event, Alarm):
        active = isinstance(event, InterlockTripped)
        new = {"seq": event.seq, "utc": event.utc, "source": event.source, "text": event.text}
        of_job = [alarm for alarm in alarms if not _is_of_rig(alarm)][1 - MOST :]
        return (*filter(_is_of_rig, alarms), *of_job, AlarmView(**new, active=active))
    if isinstance(event, InterlockCleared):
        cleared = f"interlock {event.interlock}"
        return _updated(alarms, lambda alarm: alarm.source == cleared, {"active": False})
    if isinstance(event, RunEnded):  # the interlocks are not monitored any more
        return _updated(alarms, lambda alarm: alarm.active, {"active": False, "until_end": True})
    return alarms


def _is_of_rig(alarm: AlarmView) -> bool:
    return alarm.seq == OF_RIG


def _updated(
    alarms: Alarms, which: Callable[[AlarmView], bool], update: Mapping[str, bool]
) -> Alarms:
    return tuple(
        alarm.model_copy(update=update) if which(alarm) and not _is_of_rig(alarm) else alarm
        for alarm in alarms
    )
