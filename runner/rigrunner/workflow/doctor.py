"""Whether this machine is fit to measure: what was found, and how to mend what is not right."""

from __future__ import annotations

import platform
import re
import shutil
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from importlib.metadata import PackageNotFoundError, requires, version
from typing import TYPE_CHECKING, Literal

from rigrunner import __version__
from rigrunner.workflow.locate import run_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from rigrunner.registry import Registry

OLDEST_PYTHON = (3, 11)
RELEASED = datetime(2026, 11, 1, tzinfo=UTC)
"""A clock that is before this program was written is wrong."""
AHEAD = timedelta(hours=1)
"""By which a run may be dated ahead: simulated time is faster than the clock."""
FULL_BYTES = 200_000_000
"""A long run with three channels takes about as much."""
SCARCE_BYTES = 50 * FULL_BYTES
"""A day's runs of a busy rig."""
FONT = "DejaVu Sans"
"""Of the report's plots; it comes with matplotlib."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge", "firefox")

State = Literal["ok", "warn", "fail"]


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    name: str
    state: State
    found: str
    mend: str = ""


@dataclass(frozen=True)
class Surroundings:
    """What is looked at, beside the installation itself."""

    runs: Path
    registry: Registry
    now: datetime


def examine(surroundings: Surroundings) -> list[Finding]:
    """Return all findings, in the order in which one would mend them; raises nothing."""
    return [finding for check in CHECKS for finding in _findings(check, surroundings)]


def _findings(
    check: Callable[[Surroundings], Iterator[Finding]], of: Surroundings
) -> list[Finding]:
    try:
        return list(check(of))
    except Exception as error:  # noqa: BLE001  (what is broken here is what is looked for)
        name = check.__name__.strip("_").replace("_", " ")
        return [Finding(name, "fail", f"{type(error).__name__}: {error}", "reinstall Rigrunner")]


def _python(_: Surroundings) -> Iterator[Finding]:
    oldest = ".".join(map(str, OLDEST_PYTHON))
    fit = sys.version_info[:2] >= OLDEST_PYTHON
    found = f"{platform.python_implementation()} {platform.python_version()} at {sys.executable}"
    mend = "" if fit else f"install Python {oldest} or newer"
    yield Finding("Python", "ok" if fit else "fail", found, mend)


def _packages(_: Surroundings) -> Iterator[Finding]:
    """Compare what is installed with the lower bounds in the package's own metadata."""
    needed = [line for line in requires("rigrunner") or () if "extra ==" not in line]
    found = []
    for line in needed:
        name, least = line.replace(" ", "").split(">=")
        try:
            installed = version(name)
        except PackageNotFoundError:
            yield Finding("packages", "fail", f"{name} is missing", f"pip install '{line}'")
            continue
        if _numbers(installed) < _numbers(least):
            text = f"{name} {installed} is too old"
            yield Finding("packages", "fail", text, f"pip install '{line}'")
        found.append(f"{name} {installed}")
    yield Finding("packages", "ok", f"rigrunner {__version__}, {', '.join(found)}")


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text.partition("+")[0])[:3])


def _plugins(of: Surroundings) -> Iterator[Finding]:
    count = Counter(str(plugin.provider) for plugin in of.registry.plugins)
    listing = ", ".join(f"{number} of {provider}" for provider, number in sorted(count.items()))
    state: State = "ok" if count else "fail"
    yield Finding("plugins", state, listing or "none", "" if count else "reinstall Rigrunner")
    for disabled in of.registry.disabled:
        mend = "mend or uninstall it; its plugins are not there"
        text = f"{disabled.provider} is disabled: {disabled.reason}"
        yield Finding("plugins", "warn", text, mend)
    yield from _claimed_twice(of.registry)


def _claimed_twice(registry: Registry) -> Iterator[Finding]:
    claims: dict[tuple[str, str], list[str]] = {}
    for plugin in registry.plugins:
        providers = claims.setdefault((plugin.kind, plugin.record.name), [])
        providers.append(str(plugin.provider))
    for (kind, name), providers in claims.items():
        if len(providers) > 1:
            text = f"{kind.replace('_', ' ')} '{name}' is provided by {' and '.join(providers)}"
            yield Finding("plugins", "warn", text, "uninstall one of them; neither can be used")


def _clock(of: Surroundings) -> Iterator[Finding]:
    text = f"{of.now:%Y-%m-%d %H:%M:%S} UTC"
    mend = "set the clock; let it be kept by NTP"
    newest = _newest_run(of.runs)
    if of.now < RELEASED:
        yield Finding("clock", "fail", f"{text} is before this program was written", mend)
    elif newest is not None and newest > of.now + AHEAD:
        yield Finding("clock", "warn", f"{text} is before the newest run in {of.runs}", mend)
    else:
        yield Finding("clock", "ok", text)


def _newest_run(runs: Path) -> datetime | None:
    starts = [re.match(r"\d{8}T\d{6}Z", name) for name in run_names(runs)]
    times = [datetime.strptime(f"{found[0]}+0000", "%Y%m%dT%H%M%SZ%z") for found in starts if found]
    return max(times, default=None)


def _runs_folder(of: Surroundings) -> Iterator[Finding]:
    there = of.runs.is_dir()
    folder = of.runs if there else _nearest_folder(of.runs)
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        mend = "give yourself the right to write there, or name another folder with --runs"
        yield Finding("runs folder", "fail", f"{folder}: {error.strerror or error}", mend)
    else:
        made = "can be written" if there else "will be made by the first run"
        yield Finding("runs folder", "ok", f"{of.runs.absolute()} {made}")


def _disk(of: Surroundings) -> Iterator[Finding]:
    free = shutil.disk_usage(_nearest_folder(of.runs)).free
    state: State = "ok" if free >= SCARCE_BYTES else "warn" if free >= FULL_BYTES else "fail"
    mend = "" if state == "ok" else "move old runs elsewhere, or name another disk with --runs"
    yield Finding("disk", state, f"{free / 1e9:.1f} GB free for runs", mend)


def _nearest_folder(path: Path) -> Path:
    here = path.absolute()
    return next(folder for folder in (here, *here.parents) if folder.is_dir())


def _hdf5(_: Surroundings) -> Iterator[Finding]:
    """Write and read an array in memory, compressed as runs are."""
    import h5py  # noqa: PLC0415  (heavy)

    with h5py.File("doctor.h5", "w", driver="core", backing_store=False) as file:
        file.create_dataset("values", data=[1.0, 2.0], compression="gzip", shuffle=True)
        read = list(file["values"][()])
    state: State = "ok" if read == [1.0, 2.0] else "fail"
    versions = f"HDF5 {h5py.version.hdf5_version}, h5py {h5py.version.version}"
    mend = "" if state == "ok" else "reinstall h5py: pip install --force-reinstall h5py"
    yield Finding("HDF5", state, versions, mend)


def _fonts(_: Surroundings) -> Iterator[Finding]:
    from matplotlib import font_manager  # noqa: PLC0415  (heavy)

    try:
        found = font_manager.findfont(FONT, fallback_to_default=False)
    except ValueError:
        mend = "reinstall matplotlib, which brings it"
        yield Finding("fonts", "fail", f"{FONT}, of the report's plots, is missing", mend)
    else:
        yield Finding("fonts", "ok", f"{FONT} at {found}")


def _text(_: Surroundings) -> Iterator[Finding]:
    encoding = sys.stdout.encoding or "utf-8"
    try:
        "N·m µ ± °".encode(encoding)
    except UnicodeEncodeError:
        mend = "set the environment variable PYTHONUTF8=1"
        yield Finding("text", "warn", f"{encoding} cannot show N·m, µ, ± and °", mend)
    else:
        yield Finding("text", "ok", f"{encoding} on stdout")


def _browser(_: Surroundings) -> Iterator[Finding]:
    yield _optional(
        "browser", BROWSERS, "install chromium to print reports; to look at one any will do"
    )


def _editor(_: Surroundings) -> Iterator[Finding]:
    mend = "npm install --global yaml-language-server, for an editor that helps with procedures"
    yield _optional("editor support", ("yaml-language-server",), mend)


def _pdf(_: Surroundings) -> Iterator[Finding]:
    mend = "pip install 'rigrunner[pdf]', for certificates as PDF"
    try:
        import weasyprint  # noqa: PLC0415  (optional, and heavy)
    except ImportError:
        yield Finding("PDF", "warn", "none found (optional): WeasyPrint", mend)
    except OSError as error:
        mend = "on Debian: apt install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0"
        yield Finding("PDF", "warn", f"WeasyPrint does not find the library Pango: {error}", mend)
    else:
        yield Finding("PDF", "ok", f"WeasyPrint {weasyprint.__version__}")


def _signatures(_: Surroundings) -> Iterator[Finding]:
    mend = "pip install 'rigrunner[sign]', to sign certificates and to check who signed"
    try:
        import cryptography  # noqa: PLC0415  (optional, and heavy)
    except ImportError:
        yield Finding("signatures", "warn", "none found (optional): cryptography", mend)
    else:
        yield Finding("signatures", "ok", f"cryptography {cryptography.__version__}")


def _optional(name: str, programs: tuple[str, ...], mend: str) -> Finding:
    found = next((path for path in map(shutil.which, programs) if path), None)
    if found:
        return Finding(name, "ok", found)
    return Finding(name, "warn", f"none found (optional): {', '.join(programs)}", mend)


CHECKS = (
    _python,
    _packages,
    _plugins,
    _clock,
    _runs_folder,
    _disk,
    _hdf5,
    _fonts,
    _text,
    _pdf,
    _signatures,
    _browser,
    _editor,
)
