"""The devices of a station as a unit: connect, make safe, close."""

from rigrunner.rig.rig import Patience, Rig, SafetyReport

__all__ = ["Patience", "Rig", "SafetyReport"]
