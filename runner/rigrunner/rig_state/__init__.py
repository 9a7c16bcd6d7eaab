"""State of a rig shared by all programs: who holds it, and whether it is energised."""

from rigrunner.rig_state.addresses import canonical
from rigrunner.rig_state.folder import shared_folder
from rigrunner.rig_state.locks import Busy, Holder, hold, is_held, take_over
from rigrunner.rig_state.marker import (
    DriveMark,
    Marker,
    Owner,
    clear,
    read_marker,
    read_marker_of_held,
    read_markers,
    record_made_safe,
)
from rigrunner.rig_state.marks import RigMarks

__all__ = [
    "Busy",
    "DriveMark",
    "Holder",
    "Marker",
    "Owner",
    "RigMarks",
    "canonical",
    "clear",
    "hold",
    "is_held",
    "read_marker",
    "read_marker_of_held",
    "read_markers",
    "record_made_safe",
    "shared_folder",
    "take_over",
]
