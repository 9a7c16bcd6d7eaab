"""Access to instruments: VISA libraries, NI-DAQmx, serial ports and the rights to use them."""

from __future__ import annotations

import getpass
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.tools.doctor.finding import Finding

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.tools.doctor.finding import Surroundings

_KINDS = ("TCPIP SOCKET", "TCPIP INSTR", "ASRL INSTR", "USB INSTR", "GPIB INSTR")
_VISA, _DAQMX, _SERIAL = "VISA", "NI-DAQmx", "serial ports"


def visa(_: Surroundings) -> Iterator[Finding]:
    """Check which kinds of addresses pyvisa-py supports, and look for a vendor's library."""
    try:
        debug_info = import_module("pyvisa_py.highlevel").PyVisaLibrary.get_debug_info()
        library = import_module("pyvisa.ctwrapper").IVIVisaLibrary
    except ImportError:
        yield _not_installed(_VISA, "visa")
        return
    kinds = {kind: debug_info.get(kind) for kind in _KINDS}
    supported = ", ".join(kind for kind, support in kinds.items() if isinstance(support, str))
    unsupported = "".join(
        f"; not {kind}: {support[0]}"
        for kind, support in kinds.items()
        if isinstance(support, (list, tuple))
    )
    yield Finding(_VISA, "ok", f"pyvisa-py speaks {supported} (backend @py){unsupported}")
    paths = [str(path) for path in library.get_library_paths()]
    if paths:
        yield Finding(_VISA, "ok", f"{', '.join(paths)} (backend @ivi)")
        return
    fix = "if pyvisa-py is not sufficient: install NI-VISA or Keysight IO Libraries"
    yield Finding(_VISA, "warn", "no vendor's library (optional; backend @ivi)", fix)


def daqmx(_: Surroundings) -> Iterator[Finding]:
    """Query the driver of National Instruments for its version and its devices."""
    try:
        system_class = import_module("nidaqmx.system").System
        problem = import_module("nidaqmx.errors").Error
    except ImportError:
        yield _not_installed(_DAQMX, "daq")
        return
    fix = "install NI-DAQmx from ni.com, for the plugin 'daq'; without such hardware leave it out"
    try:
        system = system_class.local()
        driver = system.driver_version
        devices = [f"{device.name} ({device.product_type})" for device in system.devices]
    except (problem, OSError) as error:
        first = str(error).strip().partition("\n")[0].partition(". ")[0]
        yield Finding(_DAQMX, "warn", f"no driver (optional): {first}", fix)
        return
    numbers = ".".join(str(part) for part in driver)
    if devices:
        yield Finding(_DAQMX, "ok", f"{numbers}; {', '.join(devices)}")
        return
    fix = "is it plugged in and on? NI MAX, or 'nilsdev' on Linux, lists what the driver sees"
    yield Finding(_DAQMX, "warn", f"{numbers} sees no device", fix)


def serial_ports(_: Surroundings) -> Iterator[Finding]:
    """List the serial ports, and those that this user may not open."""
    try:
        comports = import_module("serial.tools.list_ports").comports
    except ImportError:
        yield _not_installed(_SERIAL, "serial")
        return
    ports = sorted(port.device for port in comports())
    is_windows = sys.platform == "win32"
    denied = [port for port in ports if not is_windows and not os.access(port, os.R_OK | os.W_OK)]
    usable = [port for port in ports if port not in denied]
    if usable or not ports:
        yield Finding(_SERIAL, "ok", ", ".join(usable) or "none is seen")
    if denied:
        try:
            group = Path(denied[0]).group()
        except (OSError, KeyError, NotImplementedError):
            group = "dialout"  # which owns them on most systems
        fix = f"sudo usermod -aG {group} {getpass.getuser()}, then log in again"
        problem = f"no permission to open {', '.join(denied)}, which belongs to the group {group}"
        yield Finding(_SERIAL, "warn", problem, fix)


def _not_installed(name: str, extra: str) -> Finding:
    return Finding(name, "ok", f"not checked: the extra {extra} is not installed")
