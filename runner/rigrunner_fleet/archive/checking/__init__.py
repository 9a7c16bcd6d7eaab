"""Check that the files of an archive are unchanged, oldest check first, at a limited rate."""

from rigrunner_fleet.archive.checking.check import CheckSummary, check
from rigrunner_fleet.archive.checking.task import Pace, RunChecker

__all__ = ["CheckSummary", "Pace", "RunChecker", "check"]
