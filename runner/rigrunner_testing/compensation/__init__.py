"""Checks on compensations, with recordings of the simulated rigs."""

from rigrunner_testing.check import AnyCheck
from rigrunner_testing.compensation import invariance, numbers, refusal
from rigrunner_testing.compensation.subject import CompensationSubject

__all__ = ["CHECKS", "CompensationSubject"]

CHECKS: tuple[AnyCheck, ...] = (*numbers.CHECKS, *invariance.CHECKS, *refusal.CHECKS)
