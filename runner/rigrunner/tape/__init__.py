"""Records exchanges with instruments, and replays them without instruments."""

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
