"""The devices that talk in text. Nothing here loads numpy or a library of instruments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import DeviceRecord
from rigrunner_plugins.devices.pymeasure import trial as of_pymeasure
from rigrunner_plugins.devices.serial_ascii import trial as of_serial_ascii
from rigrunner_plugins.devices.visa import trial as of_visa

if TYPE_CHECKING:
    from rigrunner.api import Device, DeviceContext
    from rigrunner_plugins.devices.pymeasure.settings import PyMeasureSettings
    from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings
    from rigrunner_plugins.devices.visa.settings import VisaSettings


def _visa(settings: VisaSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.visa import device, streaming  # noqa: PLC0415  (numpy)

    if settings.stream is None:
        return device.Visa(settings, context)
    return streaming.StreamingVisa(settings, settings.stream, context)


def _serial_ascii(settings: SerialAsciiSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.serial_ascii import device, streaming  # noqa: PLC0415  (numpy)

    if settings.rate is None:
        return device.SerialAscii(settings, context)
    return streaming.StreamingSerialAscii(settings, settings.rate, context)


def _pymeasure(settings: PyMeasureSettings, context: DeviceContext) -> Device:
    from rigrunner_plugins.devices.pymeasure.device import make  # noqa: PLC0415  (numpy)

    return make(settings, context)


TEXT_DEVICES = (
    DeviceRecord(
        name="visa",
        help="SCPI or other ASCII instrument, over a socket, serial line, GPIB or USB",
        settings="rigrunner_plugins.devices.visa.settings:VisaSettings",
        factory=_visa,
        wired=True,
        trial=of_visa.TRIAL,
        absent=of_visa.ABSENT,
    ),
    DeviceRecord(
        name="serial_ascii",
        help="Load cell, torque transducer or balance that sends lines over a serial port",
        settings="rigrunner_plugins.devices.serial_ascii.settings:SerialAsciiSettings",
        factory=_serial_ascii,
        wired=True,
        trial=of_serial_ascii.TRIAL,
        absent=of_serial_ascii.ABSENT,
    ),
    DeviceRecord(
        name="pymeasure",
        help="Instrument for which PyMeasure has a driver: its properties as channels and drives",
        settings="rigrunner_plugins.devices.pymeasure.settings:PyMeasureSettings",
        factory=_pymeasure,
        wired=True,
        trial=of_pymeasure.TRIAL,
        absent=of_pymeasure.ABSENT,
    ),
)
