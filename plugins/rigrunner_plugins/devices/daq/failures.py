"""What NI-DAQmx raises, as the errors of a device."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

NOT_THERE = {
    "INVALID_DEVICE_ID",
    "INVALID_DEVICE_ID_IN_LIST",
    "PHYSICAL_CHAN_DOES_NOT_EXIST",
    "DEVICE_REMOVED",
}
"""Names of the library's error codes."""
OVERRUN = {
    "SAMPLES_NO_LONGER_AVAILABLE",
    "ADC_OVERRUN",
    "AI_OVERRUN",
    "CI_OVERRUN",
}
LATE = {"SAMPLES_NOT_YET_AVAILABLE", "TIMEOUT_EXCEEDED", "WAIT_UNTIL_DONE_DOES_NOT_INDICATE_DONE"}
TAKEN = {"RESOURCE_ALREADY_RESERVED", "PAL_RESOURCE_RESERVED"}
NO_DRIVER = (
    "install NI-DAQmx from ni.com for your system, restart, and look whether NI MAX, or"
    " 'nilsdev' on Linux, shows the device"
)


@contextmanager
def mapped(what: str, *, running: bool = False) -> Iterator[None]:
    """Raise a DeviceError for what the library raises; `running`: a device that was there."""
    from nidaqmx import errors  # noqa: PLC0415  (an optional package)

    try:
        yield
    except (errors.DaqNotFoundError, errors.DaqNotSupportedError) as error:
        raise DeviceNotFoundError(f"{what}: {_first(error)}", hint=NO_DRIVER) from error
    except errors.DaqError as error:
        raise _of_code(what, error.error_type.name, _first(error), running=running) from error
    except errors.Error as error:
        raise DeviceRejectedError(f"{what}: {_first(error)}") from error


def _of_code(what: str, code: str, words: str, *, running: bool) -> DeviceError:
    if code in OVERRUN:
        return DeviceLostError(
            f"{what}: samples were lost, they came faster than they were read: {words}",
            hint="record at a lower rate, use a longer buffer, or reduce the load of the computer",
        )
    if code in NOT_THERE:
        kind = DeviceLostError if running else DeviceNotFoundError
        return kind(f"{what}: {words}", hint="is it plugged in, and has it this name in NI MAX?")
    if code in LATE:
        hint = "does the sample clock run? see sample_clock, and the chassis of the module"
        return DeviceTimeoutError(f"{what}: {words}", hint=hint)
    if code in TAKEN:
        return DeviceRejectedError(f"{what}: {words}", hint="close the program that uses it")
    return DeviceRejectedError(f"{what}: {words}")


def _first(error: Exception) -> str:
    """Return the first sentence of what the driver says; it adds paragraphs of properties."""
    return str(error).strip().partition("\n")[0].rstrip(".")
