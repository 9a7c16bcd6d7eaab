"""The extras: which are installed, and the purpose of the others."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout
from importlib.metadata import PackageNotFoundError, requires, version
from typing import TYPE_CHECKING

from rigrunner.tools.doctor.finding import Finding
from rigrunner.tools.doctor.installation import numbers

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.tools.doctor.finding import Surroundings

PURPOSES = {
    "apprise": "messages to desktops, phones and chats",
    "daq": "data acquisition by National Instruments",
    "dask": "batches of analyses on a cluster",
    "export": "data frames, datasets and Parquet files of an archive",
    "modbus": "inverters, presses and others that talk Modbus",
    "mqtt": "messages to an MQTT broker",
    "opcua": "controllers that are OPC UA servers",
    "panel": "the operator's panel",
    "pdf": "certificates as PDF",
    "postgresql": "an archive on a PostgreSQL server",
    "pymeasure": "the instruments that PyMeasure knows",
    "serial": "load cells and others on a serial line",
    "sign": "signatures of certificates",
    "tdms": "importing TDMS files",
    "visa": "SCPI and other instruments behind VISA",
}
TOOLS = ("dev", "docs", "fuzz", "peers", "test")
"""Extras for those who change Rigrunner itself."""
_LINE = re.compile(r"([\w.-]+)(?:\[\w+\])?\s*([^;]*);\s*extra == ['\"](\w+)['\"]")
_BOUND = re.compile(r"(>=|<)\s*([\d.]+)")


def each_extra(_: Surroundings) -> Iterator[Finding]:
    """Compare the installed packages with what each extra requires in the package's metadata."""
    asked: dict[str, dict[str, str]] = {}
    for line in requires("rigrunner") or ():
        found = _LINE.match(line)
        if found and found[3] not in TOOLS and found[1] != "rigrunner":
            asked.setdefault(found[3], {})[found[1]] = found[2]
    for extra, packages in sorted(asked.items()):
        yield _extra(extra, packages)
    if not asked:
        fix = "install Rigrunner again: its metadata are of an older version"
        yield Finding("extras", "warn", "its own metadata name none", fix)


def _extra(extra: str, packages: dict[str, str]) -> Finding:
    name, purpose = f"extra {extra}", PURPOSES.get(extra, "a plugin")
    fix = f"pip install 'rigrunner[{extra}]', for {purpose}"
    found = {package: _installed(package) for package in packages}
    if not any(found.values()):
        return Finding(name, "warn", f"not installed (optional): {', '.join(packages)}", fix)
    wrong = [
        text for package, bounds in packages.items() if (text := _wrong(package, found, bounds))
    ]
    if wrong:
        return Finding(name, "warn", ", ".join(wrong), fix)
    broken = _broken(extra)
    if broken is not None:
        return Finding(name, "warn", *broken)
    return Finding(name, "ok", ", ".join(f"{each} {found[each]}" for each in packages))


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _wrong(package: str, found: dict[str, str], bounds: str) -> str:
    installed = found[package]
    if not installed:
        return f"{package} is missing"
    for sign, bound in _BOUND.findall(bounds):
        if sign == ">=" and numbers(installed) < numbers(bound):
            return f"{package} {installed} is too old: expected {bound}"
        if sign == "<" and numbers(installed) >= numbers(bound):
            return f"{package} {installed} is too new: expected a version below {bound}"
    return ""


def _broken(extra: str) -> tuple[str, str] | None:
    """Return what is wrong with an installed package, and how to fix it."""
    if extra != "pdf":
        return None
    try:
        with redirect_stdout(io.StringIO()):  # where Pango is missing it prints what we say below
            import weasyprint  # noqa: F401, PLC0415  (optional, heavy, and loads libraries)
    except OSError as error:
        fix = "on Debian: apt install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0"
        return f"WeasyPrint does not find the library Pango: {error}", fix
    return None
