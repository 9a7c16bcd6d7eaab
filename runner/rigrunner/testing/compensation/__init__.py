"""Checks on compensations, with recordings of the simulated rigs."""

from rigrunner.testing.check import AnyCheck
from rigrunner.testing.compensation import invariance, numbers, refusal
from rigrunner.testing.compensation.subject import CompensationSubject

__all__ = ["CHECKS", "CompensationSubject"]

CHECKS: tuple[AnyCheck, ...] = (*numbers.CHECKS, *invariance.CHECKS, *refusal.CHECKS)
