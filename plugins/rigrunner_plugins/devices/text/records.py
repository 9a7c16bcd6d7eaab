"""The devices that talk in text. Nothing here loads numpy or a library of instruments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.hooks import DeviceRecord
from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings
from rigrunner_plugins.devices.serial_ascii.trial import TRIAL as SERIAL_TRIAL
from rigrunner_plugins.devices.visa.settings import VisaSettings
from rigrunner_plugins.devices.visa.trial import TRIAL as VISA_TRIAL

if TYPE_CHECKING:
    from rigrunner.api.devices import Device, DeviceContext


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


TEXT_DEVICES = (
    DeviceRecord(
        name="visa",
        help="Instrument that talks SCPI or other ASCII, over a socket, serial line, GPIB, USB",
        settings=VisaSettings,
        factory=_visa,
        wired=True,
        trial=VISA_TRIAL,
    ),
    DeviceRecord(
        name="serial_ascii",
        help="Load cell, torque transducer or balance that sends lines over a serial port",
        settings=SerialAsciiSettings,
        factory=_serial_ascii,
        wired=True,
        trial=SERIAL_TRIAL,
    ),
)
