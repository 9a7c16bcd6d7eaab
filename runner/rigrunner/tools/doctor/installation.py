"""The installation: Python, the packages that Rigrunner needs, its extras, and the plugins."""

from __future__ import annotations

import io
import platform
import re
import sys
from collections import Counter
from contextlib import redirect_stdout
from importlib.metadata import PackageNotFoundError, requires, version
from typing import TYPE_CHECKING

from rigrunner import __version__
from rigrunner.api.errors import InvalidFileError, RigrunnerError
from rigrunner.tools.by_hand.station import ready_station
from rigrunner.tools.doctor.finding import Finding, State, Surroundings

if TYPE_CHECKING:
    from collections.abc import Iterator

OLDEST_PYTHON = (3, 11)
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
_LINE = re.compile(r"([\w.-]+)(?:\[\w+\])?\s*([^;]*)(?:;\s*extra == ['\"](\w+)['\"])?")
_BOUND = re.compile(r"(>=|<|!=)\s*([\d.]+)")


def python(_: Surroundings) -> Iterator[Finding]:
    """Compare Python with the oldest supported version."""
    oldest = ".".join(map(str, OLDEST_PYTHON))
    is_supported = sys.version_info[:2] >= OLDEST_PYTHON
    name = f"{platform.python_implementation()} {platform.python_version()}"
    fix = "" if is_supported else f"install Python {oldest} or newer"
    state: State = "ok" if is_supported else "fail"
    yield Finding("Python", state, f"{name} at {sys.executable}", fix)


def packages(_: Surroundings) -> Iterator[Finding]:
    """Compare what is installed with the bounds in the package's metadata."""
    versions = [f"rigrunner {__version__}"]
    for line in requires("rigrunner") or ():
        name, bounds, extra = _requirement(line)
        if extra:
            continue
        installed = _installed(name)
        if problem := _version_problem(name, installed, bounds):
            yield Finding("packages", "fail", problem, f"pip install '{line}'")
        if installed:
            versions.append(f"{name} {installed}")
    yield Finding("packages", "ok", ", ".join(versions))


def _requirement(text: str) -> tuple[str, str, str]:
    """Return the package, the bounds and the extra ('': none) of a line of the metadata."""
    match = _LINE.match(text)
    return (match[1], match[2], match[3] or "") if match else (text, "", "")


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def numbers(text: str) -> tuple[int, ...]:
    """Return the numbers of a version, of which the first three count."""
    return tuple(int(part) for part in re.findall(r"\d+", text.partition("+")[0])[:3])


def plugins(surroundings: Surroundings) -> Iterator[Finding]:
    """Count the plugins by provider; report disabled ones, and names used twice."""
    count = Counter(str(plugin.provider) for plugin in surroundings.registry.plugins)
    listing = ", ".join(f"{number} of {provider}" for provider, number in sorted(count.items()))
    state: State = "ok" if count else "fail"
    yield Finding("plugins", state, listing or "none", "" if count else "reinstall Rigrunner")
    for disabled in surroundings.registry.disabled:
        fix = "fix or uninstall it; its plugins are not available"
        text = f"{disabled.provider} is disabled: {disabled.reason}"
        yield Finding("plugins", "warn", text, fix)
    claims: dict[tuple[str, str], list[str]] = {}
    for plugin in surroundings.registry.plugins:
        claims.setdefault((plugin.kind, plugin.record.name), []).append(str(plugin.provider))
    for (kind, name), providers in claims.items():
        if len(providers) > 1:
            text = f"{kind.replace('_', ' ')} '{name}' is provided by {' and '.join(providers)}"
            yield Finding("plugins", "warn", text, "uninstall one of them; neither can be used")


def station(surroundings: Surroundings) -> Iterator[Finding]:
    """Create the devices of the station, with its plugins; no instrument is accessed."""
    if surroundings.station is None:
        yield Finding("station", "ok", "not checked: name one with --station")
        return
    try:
        ready = ready_station(surroundings.station)
    except InvalidFileError as error:
        for problem in error.problems:
            fix = problem.hint or "'rigrunner check' lists all problems in it"
            where = f"{problem.location}: " if problem.location else ""
            yield Finding("station", "fail", f"{where}{problem.message}", fix)
        return
    except RigrunnerError as error:
        yield Finding("station", "fail", error.message, error.hint or "correct the file")
        return
    roles = ", ".join(ready.devices)
    text = f"{surroundings.station}: its plugins take the settings of {roles}"
    yield Finding("station", "ok", f"{text}; 'rigrunner devices' connects them")


def extras(_: Surroundings) -> Iterator[Finding]:
    """Compare the installed packages with what each extra requires in the package's metadata."""
    requirements: dict[str, dict[str, str]] = {}
    for line in requires("rigrunner") or ():
        name, bounds, extra = _requirement(line)
        if extra and extra not in TOOLS and name != "rigrunner":
            requirements.setdefault(extra, {})[name] = bounds
    for extra, packages in sorted(requirements.items()):
        yield _extra(extra, packages)
    if not requirements:
        fix = "install Rigrunner again: its metadata are of an older version"
        yield Finding("extras", "warn", "its own metadata name none", fix)


def _extra(extra: str, packages: dict[str, str]) -> Finding:
    name, purpose = f"extra {extra}", PURPOSES.get(extra, "a plugin")
    fix = f"pip install 'rigrunner[{extra}]', for {purpose}"
    versions = {package: _installed(package) for package in packages}
    if not any(versions.values()):
        return Finding(name, "warn", f"not installed (optional): {', '.join(packages)}", fix)
    problems = [
        text
        for package, bounds in packages.items()
        if (text := _version_problem(package, versions[package], bounds))
    ]
    if problems:
        return Finding(name, "warn", ", ".join(problems), fix)
    if extra == "pdf":  # it needs libraries of the system too
        try:
            with redirect_stdout(io.StringIO()):  # without Pango it prints what we report
                import weasyprint  # noqa: F401, PLC0415  (optional, heavy, and loads libraries)
        except OSError as error:
            text = f"WeasyPrint does not find the library Pango: {error}"
            fix = "on Debian: apt install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0"
            return Finding(name, "warn", text, fix)
    return Finding(name, "ok", ", ".join(f"{package} {versions[package]}" for package in packages))


def _version_problem(package: str, installed: str, bounds: str) -> str:
    if not installed:
        return f"{package} is missing"
    for sign, bound in _BOUND.findall(bounds):
        if sign == ">=" and numbers(installed) < numbers(bound):
            return f"{package} {installed} is too old: expected {bound}"
        if sign == "<" and numbers(installed) >= numbers(bound):
            return f"{package} {installed} is too new: expected a version below {bound}"
        if sign == "!=" and numbers(installed) == numbers(bound):
            return f"{package} {installed} has a known defect: expected another version"
    return ""
