"""The devices of a station as a unit: connect, make safe, close."""

from rigrunner.rig.rig import Rig
from rigrunner.rig.safe_state import SafetyReport
from rigrunner.rig.worker import Patience

__all__ = ["Patience", "Rig", "SafetyReport"]
