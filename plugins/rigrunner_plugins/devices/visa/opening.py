"""Opening a resource of PyVISA, and what its back ends do not report by themselves."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

from rigrunner.api import DeviceNotFoundError
from rigrunner_plugins.devices.extras import missing_package

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner_plugins.devices.visa.settings import VisaSettings

_IPPROTO_TCP = 6
_TCP_NODELAY = 1
_MSG_PEEK = 2
"""The numbers of IANA and of every operating system; pyvisa-py refuses the VISA attribute."""


def open_resource(settings: VisaSettings, folder: Path, timeout_s: float) -> Any:
    """Return the open resource; raise DeviceNotFoundError, or MissingPackageError.

    `folder` is that of the station, in which a simulation's file lies.
    """
    manager, name = _manager(settings.backend, folder), settings.resource
    try:
        resource = manager.open_resource(name, open_timeout=int(timeout_s * 1000))
    except Exception as error:  # pyvisa-py raises nothing more special for many of its failures
        raise open_error(name, error) from error
    try:
        _set_up(resource, settings)
    except Exception as error:
        close_resource(resource)
        raise open_error(name, error) from error
    if is_gone(resource):
        close_resource(resource)
        raise DeviceNotFoundError(f"no answer from {name}", hint=_hint(name, ""))
    send_at_once(resource)
    return resource


def close_resource(resource: Any) -> None:
    """Give a resource back, whatever state it is in."""
    with suppress(Exception):
        resource.close()


def library(backend: str, folder: Path) -> str:
    """Return the backend as PyVISA takes it; `folder` is that of the station."""
    return str(folder / backend) if backend.endswith(".yaml@sim") else backend


def open_error(name: str, error: Exception) -> DeviceNotFoundError:
    """Return the error for a resource that cannot be opened."""
    text = str(error) or type(error).__name__
    return DeviceNotFoundError(f"{name} cannot be opened: {text}", hint=_hint(name, text))


def _manager(backend: str, folder: Path) -> Any:
    """Return the resource manager, which is shared and never closed."""
    try:
        import pyvisa  # noqa: PLC0415  (slow, and optional)
    except ImportError as error:
        raise missing_package("pyvisa", "visa") from error
    try:
        return pyvisa.ResourceManager(library(backend, folder))
    except Exception as error:  # of any kind, from whatever library that is
        raise DeviceNotFoundError(
            f"the backend '{backend}' cannot be loaded: {error}",
            hint="@py needs pyvisa-py, @sim pyvisa-sim, @ivi a vendor's VISA library",
        ) from error


def _set_up(resource: Any, settings: VisaSettings) -> None:
    resource.timeout = settings.timeout * 1000
    if settings.termination:
        resource.read_termination = settings.termination
    if not settings.resource.startswith("ASRL"):
        return
    from pyvisa import constants  # noqa: PLC0415  (slow, and optional)

    line = settings.serial
    stop_bits = {1: constants.StopBits.one, 2: constants.StopBits.two}
    resource.baud_rate = line.baud
    resource.data_bits = line.data_bits
    resource.parity = constants.Parity[line.parity]
    resource.stop_bits = stop_bits[line.stop_bits]
    resource.flow_control = constants.ControlFlow[line.flow_control]


def _hint(name: str, error_text: str) -> str:
    if "denied" in error_text.lower():
        return "no permission to use that port; on Linux, join its group, often 'dialout'"
    if name.startswith("TCPIP"):
        return "is the instrument switched on, the address correct, and its network port enabled?"
    return (
        "is the instrument switched on and plugged in? the command `list` of `pyvisa-shell`"
        " lists connected ones"
    )


def send_at_once(resource: Any) -> None:
    """Have each message sent at once.

    A query that follows a command waits 40 ms else, until the other end has acknowledged the
    command (RFC 896, RFC 1122 4.2.3.2).
    """
    socket = _socket_of(resource)
    if socket is not None:
        socket.setsockopt(_IPPROTO_TCP, _TCP_NODELAY, 1)


def is_gone(resource: Any) -> bool:
    """Return whether a socket has lost its other end.

    pyvisa-py takes a refused connection for an open one, and one that was closed for a slow one.
    """
    socket = _socket_of(resource)
    if socket is None:
        return False
    try:
        socket.getpeername()
        socket.settimeout(0)
        try:
            return bool(socket.recv(1, _MSG_PEEK) == b"")  # the end of what the other one sends
        finally:
            socket.settimeout(None)
    except BlockingIOError:
        return False
    except OSError:
        return True


def _socket_of(resource: Any) -> Any:
    """Return the socket below a resource; None of any other one, and of other back ends."""
    sessions = getattr(resource.visalib, "sessions", {})
    interface = getattr(sessions.get(resource.session), "interface", None)
    return interface if hasattr(interface, "getpeername") else None
