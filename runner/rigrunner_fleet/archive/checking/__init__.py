"""Check that the files of an archive are unchanged, oldest check first, at a limited rate."""

from rigrunner_fleet.archive.checking.check import Checked, check
from rigrunner_fleet.archive.checking.task import Look, Pace

__all__ = ["Checked", "Look", "Pace", "check"]
