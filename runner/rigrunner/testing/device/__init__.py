"""Checks on device plugins."""

from rigrunner.testing.check import AnyCheck
from rigrunner.testing.device import (
    connection,
    failures,
    quantities,
    safety,
    simulators,
    streams,
)
from rigrunner.testing.device.subject import DeviceSubject

__all__ = ["CHECKS", "DeviceSubject"]

CHECKS: tuple[AnyCheck, ...] = (
    *connection.CHECKS,
    *quantities.CHECKS,
    *safety.CHECKS,
    *streams.CHECKS,
    *simulators.CHECKS,
    *failures.CHECKS,
    safety.left_safe,
)
