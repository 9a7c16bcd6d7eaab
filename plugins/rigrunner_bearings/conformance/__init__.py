"""Checks on compensations, with recordings of the simulated rigs."""

from rigrunner_bearings.conformance import invariance, numbers, refusal
from rigrunner_bearings.conformance.subject import CompensationSubject
from rigrunner_testing import AnyCheck

CHECKS: tuple[AnyCheck, ...] = (*numbers.CHECKS, *invariance.CHECKS, *refusal.CHECKS)
SUBJECT = CompensationSubject
