"""The devices of a station as a unit: connect, make safe, close."""

from rigrunner.api.devices import Patience
from rigrunner.rig.drives import agrees
from rigrunner.rig.pulse import Pulse
from rigrunner.rig.rig import Rig
from rigrunner.rig.safe_state import (
    NoRigError,
    SafetyReport,
    note_unsafe,
    problems_text,
    unsafe_text,
)

__all__ = [
    "NoRigError",
    "Patience",
    "Pulse",
    "Rig",
    "SafetyReport",
    "agrees",
    "note_unsafe",
    "problems_text",
    "unsafe_text",
]
