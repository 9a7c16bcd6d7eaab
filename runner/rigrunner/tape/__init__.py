"""Saves what a run exchanges with its instruments, and plays it back without them."""

from rigrunner.tape.manifest import (
    TapedFile,
    TapedOverride,
    TapedPlugin,
    TapeManifest,
)
from rigrunner.tape.recorded import RecordedTape
from rigrunner.tape.replayed import ReplayedTape
from rigrunner.tape.tape import Tape

__all__ = [
    "RecordedTape",
    "ReplayedTape",
    "Tape",
    "TapeManifest",
    "TapedFile",
    "TapedOverride",
    "TapedPlugin",
]
