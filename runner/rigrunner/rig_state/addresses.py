"""Canonical addresses of instruments: two names of one port are one address."""

from __future__ import annotations

import ipaddress
import os
import re
import socket
import sys
import threading

_RESOLVE_S = 2.0
"""Time limit of a name lookup in the network; after it the name is used as it is."""
_LOOPBACK = "127.0.0.1"


def canonical(address: str) -> frozenset[str]:
    """Return the canonical forms of an address, such as 'tcp:localhost:502'.

    It is 'serial:PORT', 'tcp:HOST:PORT' with anything after a '/', 'visa:RESOURCE', or any other
    'kind:name'. A host with several IP addresses has one for each.
    """
    kind, _, place = address.partition(":")
    match kind:
        case "serial":
            return frozenset({f"serial:{_port(place)}"})
        case "tcp":
            return _tcp(place)
        case "visa":
            return _visa(place)
        case "daq":  # a module is of its chassis, which has one clock
            return frozenset({f"daq:{re.sub(r'Mod[0-9]+$', '', place).casefold()}"})
    return frozenset({f"{kind}:{place.strip()}"})


def _port(name: str) -> str:
    """Return the system name of a serial port, following links."""
    name = name.strip().removeprefix("\\\\.\\")
    if re.fullmatch(r"com[0-9]+", name, re.IGNORECASE):
        return name.upper()
    return os.path.realpath(name) if name.startswith("/") else name


def _tcp(place: str) -> frozenset[str]:
    place, slash, suffix = place.partition("/")
    host, _, port = place.rpartition(":")
    return frozenset(f"tcp:{ip}:{port}{slash}{suffix}" for ip in _host_ips(host.strip("[] ")))


def _visa(resource: str) -> frozenset[str]:
    """Return a VISA resource in canonical form: VPP-4.3, section 4.3.1.1."""
    parts = resource.strip().split("::")
    head = re.fullmatch(r"([A-Za-z]+?)(\d*|/.*|COM\d+)", parts[0], re.IGNORECASE)
    if head is None:
        return frozenset({f"visa:{resource.strip().upper()}"})
    bus, board = head[1].upper(), head[2]
    match bus, parts[1:]:
        case "ASRL", _:
            on_windows = sys.platform == "win32" and board.isdigit()
            return frozenset({f"serial:{_port(f'COM{board}' if on_windows else board)}"})
        case "TCPIP", [host, port, kind] if kind.upper() == "SOCKET":
            return _tcp(f"{host}:{port}")
        case "TCPIP", [host, *rest]:
            # The device name is optional; VPP-4.3 takes inst0 then.
            name = rest[0].lower() if rest and rest[0].upper() != "INSTR" else "inst0"
            return frozenset(f"visa:TCPIP::{ip}::{name}" for ip in _host_ips(host))
        case _, rest:
            fields = [_number(field) for field in rest if field.upper() != "INSTR"]
            return frozenset({"::".join((f"visa:{bus}{board or 0}", *fields)).upper()})


def _number(text: str) -> str:
    """Return a number in decimal digits; VISA also has hexadecimal ones."""
    try:
        return str(int(text, 0))
    except ValueError:
        return text


def _host_ips(host: str) -> frozenset[str]:
    """Return the IP addresses of a host, one for all of this machine; its name if unknown."""
    ips: list[str] = []

    def look_up() -> None:
        try:
            ips.extend(str(entry[4][0]) for entry in socket.getaddrinfo(host, None))
        except (OSError, UnicodeError):
            return

    # In a thread, as a look-up has no time limit of its own.
    thread = threading.Thread(target=look_up, name=f"resolve {host}", daemon=True)
    thread.start()
    thread.join(_RESOLVE_S)
    return frozenset(_canonical_ip(ip) for ip in ips) or frozenset({host.casefold()})


def _canonical_ip(text: str) -> str:
    # Without the zone of a link-local IPv6 address: "fe80::1%eth0".
    number = ipaddress.ip_address(text.partition("%")[0])
    if isinstance(number, ipaddress.IPv6Address) and number.ipv4_mapped is not None:
        number = number.ipv4_mapped
    return _LOOPBACK if number.is_loopback or number.is_unspecified else str(number)
