"""Checks on formats of reports and of certificates."""

from rigrunner.testing.check import AnyCheck
from rigrunner.testing.formats.checks import CHECKS as _CHECKS
from rigrunner.testing.formats.subject import FormatSubject

__all__ = ["CHECKS", "FormatSubject"]

CHECKS: tuple[AnyCheck, ...] = _CHECKS
