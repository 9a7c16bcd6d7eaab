"""The devices of a station as a unit: connect, make safe, close."""

from rigrunner.api.devices import Patience
from rigrunner.rig.drives import agrees
from rigrunner.rig.rig import Rig
from rigrunner.rig.safe_state import NoRigError, SafetyReport, problems_text, unsafe_text

__all__ = [
    "NoRigError",
    "Patience",
    "Rig",
    "SafetyReport",
    "agrees",
    "problems_text",
    "unsafe_text",
]
