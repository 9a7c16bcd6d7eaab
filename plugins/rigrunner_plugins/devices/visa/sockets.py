"""The sockets of pyvisa-py, which hides more of them than is good."""

from __future__ import annotations

from typing import Any

_IPPROTO_TCP = 6
_TCP_NODELAY = 1
_MSG_PEEK = 2
"""The numbers of IANA and of every operating system; pyvisa-py refuses the VISA attribute."""


def send_at_once(resource: Any) -> None:
    """Have each message sent at once.

    A query that follows a command waits 40 ms else, until the other end has acknowledged the
    command (RFC 896, RFC 1122 4.2.3.2).
    """
    socket = _socket_of(resource)
    if socket is not None:
        socket.setsockopt(_IPPROTO_TCP, _TCP_NODELAY, 1)


def is_gone(resource: Any) -> bool:
    """Say whether a socket is connected to nobody.

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
