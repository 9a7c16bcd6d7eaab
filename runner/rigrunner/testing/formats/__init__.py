"""Checks on formats of reports and of certificates."""

from rigrunner.testing.check import AnyCheck
from rigrunner.testing.formats.checks import CHECKS as _CHECKS

__all__ = ["CHECKS"]

CHECKS: tuple[AnyCheck, ...] = _CHECKS
