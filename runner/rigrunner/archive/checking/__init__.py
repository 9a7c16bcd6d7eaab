"""Whether the files of an archive are what they were: read in order of age, at a bounded rate."""

from rigrunner.archive.checking.check import Checked, check
from rigrunner.archive.checking.pace import Pace
from rigrunner.archive.checking.task import Look

__all__ = ["Checked", "Look", "Pace", "check"]
