"""Checks on formats of reports and of certificates."""

from rigrunner_testing.check import AnyCheck
from rigrunner_testing.formats.checks import CHECKS as _CHECKS
from rigrunner_testing.formats.subject import FormatSubject

__all__ = ["CHECKS", "FormatSubject"]

CHECKS: tuple[AnyCheck, ...] = _CHECKS
