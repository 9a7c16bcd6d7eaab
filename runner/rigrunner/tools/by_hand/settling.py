"""Before a start asks anything: report a rig that was left energised, and make it safe."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DeviceError
from rigrunner.rig_state import read_marker
from rigrunner.run.left_energised import check_left, what_to_do
from rigrunner.tools.by_hand.station import ready_station

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.run.left_energised import Person


def settle_left(station: Path, person: Person, *, always: bool = False) -> None:
    """Handle a rig that was left energised before a person is asked anything else.

    The person sees the marker and the read-backs of the drives. Then the rig is made safe, or the
    start ends with AbortedError. Raises DeviceError if the rig cannot be connected, or is not
    confirmed safe. Without a marker nothing is connected, unless `always` is set.
    """
    ready = ready_station(station, realtime=True)
    if not always and read_marker(ready.station.model.id) is None:
        return
    with ready.hold("make safe") as held:
        if held.marks is None:
            return
        left = held.marks.left
        if left is not None:
            person.warn(left.text)
        rig = held.rig(held.devices)
        try:
            rig.connect()
        except DeviceError as error:
            if left is not None:
                error.message = f"{error.message}; {left.text}"
            error.hint = error.hint or what_to_do(held.station.document.name)
            raise
        try:
            check_left(rig, held.marks, person, held.station.document.name)
        finally:
            rig.close()
