"""Whether the files of an archive are what they were: read in order of age, at a bounded rate."""

from rigrunner.archive.checking.check import Checked, check
from rigrunner.archive.checking.pace import Pace
from rigrunner.archive.checking.task import Finding, Kind, Look

__all__ = ["Checked", "Finding", "Kind", "Look", "Pace", "check"]
