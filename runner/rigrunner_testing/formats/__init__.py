"""Checks on formats of reports and of certificates."""

from rigrunner_testing.formats.checks import CHECKS
from rigrunner_testing.formats.subject import FormatSubject

__all__ = ["CHECKS", "FormatSubject"]
