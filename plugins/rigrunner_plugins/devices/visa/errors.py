"""What PyVISA and the libraries below it raise, in the words of the four errors of a device."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rigrunner.api import DeviceLostError, DeviceTimeoutError
from rigrunner_plugins.devices.visa.opening import is_gone

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def visa_errors(problem: str, timeout_s: float, resource: Any, hint: str) -> Iterator[None]:
    """Raise DeviceTimeoutError with the hint, or DeviceLostError, for what goes wrong within."""
    from pyvisa.constants import StatusCode  # noqa: PLC0415  (slow, and optional)
    from pyvisa.errors import Error, VisaIOError  # noqa: PLC0415  (an optional package)

    try:
        yield
    except VisaIOError as error:
        if error.error_code != StatusCode.error_timeout:
            raise DeviceLostError(f"{problem}: {error.description}") from error
        if is_gone(resource):
            raise DeviceLostError(f"{problem}: the other end closed the connection") from error
        raise DeviceTimeoutError(f"{problem} within {timeout_s:g} s", hint=hint) from error
    except Error as error:
        raise DeviceLostError(f"{problem}: {error}") from error
    except OSError as error:  # of sockets; also pyserial's SerialException
        raise DeviceLostError(f"{problem}: {error.strerror or error}") from error
