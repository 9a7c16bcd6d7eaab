"""What a laboratory needs that tests bearings. Nothing here loads numpy."""

from __future__ import annotations

from rigrunner_bearings.compensations.records import rigrunner_compensations, rigrunner_kinds
from rigrunner_bearings.devices.records import rigrunner_devices
from rigrunner_bearings.fits.records import rigrunner_fits
from rigrunner_bearings.labs import rigrunner_labs
from rigrunner_bearings.torque.records import rigrunner_analyses

__all__ = [
    "api_version",
    "rigrunner_analyses",
    "rigrunner_compensations",
    "rigrunner_devices",
    "rigrunner_fits",
    "rigrunner_kinds",
    "rigrunner_labs",
]

api_version = 1
