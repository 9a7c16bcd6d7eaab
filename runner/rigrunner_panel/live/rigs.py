"""Rigs of this machine that were left energised, as alarms that stay until one is on record."""

from __future__ import annotations

from rigrunner.rig_state import read_markers
from rigrunner_panel.view.sections import AlarmView


def alarms_of_rigs() -> tuple[AlarmView, ...]:
    """Return an alarm for each rig that was left energised and that no process holds now.

    It is active until something has read back that the rig is safe.
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
        if not marker.is_in_use
    )
