"""Checks on device plugins."""

from rigrunner_testing.check import AnyCheck
from rigrunner_testing.device import (
    connection,
    failures,
    quantities,
    recovery,
    safety,
    simulators,
    streams,
)
from rigrunner_testing.device.subject import DeviceSubject

__all__ = ["CHECKS", "DeviceSubject"]

CHECKS: tuple[AnyCheck, ...] = (
    *connection.CHECKS,
    *quantities.CHECKS,
    *streams.CHECKS,
    *safety.CHECKS,
    connection.gives_back_what_it_took,
    *simulators.CHECKS,
    *failures.CHECKS,
    *recovery.CHECKS,
    safety.left_safe,
)
