"""The machine: clock, disk, and the programs and fonts that reports need."""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

from rigrunner.run.locate import run_names
from rigrunner.tools.doctor.finding import Finding, State, Surroundings

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

RELEASE_DATE = datetime(2026, 11, 1, tzinfo=UTC)
"""A clock before this date, that of the release, is wrong."""
AHEAD = timedelta(hours=1)
"""How far a run may be dated ahead: simulated time is faster than the clock."""
FULL_BYTES = 200_000_000
"""The size of a long run with three channels."""
SCARCE_BYTES = 50 * FULL_BYTES
"""The size of a day's runs of a busy rig."""
FONT = "DejaVu Sans"
"""The font of the report's plots, which comes with matplotlib."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge", "firefox")


def clock(surroundings: Surroundings) -> Iterator[Finding]:
    """Check the clock, as far as a machine can by itself."""
    text = f"{surroundings.now:%Y-%m-%d %H:%M:%S} UTC"
    fix = "set the clock, and synchronise it by NTP"
    starts = [re.match(r"\d{8}T\d{6}Z", name) for name in run_names(surroundings.runs)]
    times = [datetime.strptime(f"{match[0]}+0000", "%Y%m%dT%H%M%SZ%z") for match in starts if match]
    newest = max(times, default=None)
    if surroundings.now < RELEASE_DATE:
        yield Finding("clock", "fail", f"{text} is before this program was written", fix)
    elif newest is not None and newest > surroundings.now + AHEAD:
        problem = f"{text} is before the newest run in {surroundings.runs}"
        yield Finding("clock", "warn", problem, fix)
    else:
        yield Finding("clock", "ok", text)


def runs_folder(surroundings: Surroundings) -> Iterator[Finding]:
    """Try to write to the folder of runs."""
    exists = surroundings.runs.is_dir()
    folder = surroundings.runs if exists else _nearest_folder(surroundings.runs)
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        fix = "get write permission there, or name another folder with --runs"
        yield Finding("runs folder", "fail", f"{folder}: {error.strerror or error}", fix)
    else:
        state = "can be written" if exists else "will be created by the first run"
        yield Finding("runs folder", "ok", f"{surroundings.runs.absolute()} {state}")


def disk(surroundings: Surroundings) -> Iterator[Finding]:
    """Check the free space for runs."""
    free = shutil.disk_usage(_nearest_folder(surroundings.runs)).free
    state: State = "ok" if free >= SCARCE_BYTES else "warn" if free >= FULL_BYTES else "fail"
    fix = "" if state == "ok" else "move old runs elsewhere, or name another disk with --runs"
    yield Finding("disk", state, f"{free / 1e9:.1f} GB free for runs", fix)


def _nearest_folder(path: Path) -> Path:
    absolute = path.absolute()
    return next(folder for folder in (absolute, *absolute.parents) if folder.is_dir())


def hdf5(_: Surroundings) -> Iterator[Finding]:
    """Write and read an array in memory, compressed like run files."""
    import h5py  # noqa: PLC0415  (heavy)

    with h5py.File("doctor.h5", "w", driver="core", backing_store=False) as file:
        file.create_dataset("values", data=[1.0, 2.0], compression="gzip", shuffle=True)
        read = list(file["values"][()])
    state: State = "ok" if read == [1.0, 2.0] else "fail"
    versions = f"HDF5 {h5py.version.hdf5_version}, h5py {h5py.version.version}"
    fix = "" if state == "ok" else "reinstall h5py: pip install --force-reinstall h5py"
    yield Finding("HDF5", state, versions, fix)


def fonts(_: Surroundings) -> Iterator[Finding]:
    """Look for the font of the report's plots."""
    from matplotlib import font_manager  # noqa: PLC0415  (heavy)

    try:
        path = font_manager.findfont(FONT, fallback_to_default=False)
    except ValueError:
        fix = "reinstall matplotlib, which brings it"
        yield Finding("fonts", "fail", f"{FONT}, of the report's plots, is missing", fix)
    else:
        yield Finding("fonts", "ok", f"{FONT} at {path}")


def text(_: Surroundings) -> Iterator[Finding]:
    """Check whether the terminal can show the printed characters."""
    encoding = sys.stdout.encoding or "utf-8"
    try:
        "N·m µ ± °".encode(encoding)
    except UnicodeEncodeError:
        fix = "set the environment variable PYTHONUTF8=1"
        yield Finding("text", "warn", f"{encoding} cannot show N·m, µ, ± and °", fix)
    else:
        yield Finding("text", "ok", f"{encoding} on stdout")


def browser(_: Surroundings) -> Iterator[Finding]:
    """Look for a browser."""
    fix = "install chromium to print reports; any browser displays them"
    yield _optional("browser", BROWSERS, fix)


def editor(_: Surroundings) -> Iterator[Finding]:
    """Look for the language server that helps editors with YAML."""
    fix = "npm install --global yaml-language-server, for an editor that helps with procedures"
    yield _optional("editor support", ("yaml-language-server",), fix)


def _optional(name: str, programs: tuple[str, ...], fix: str) -> Finding:
    program = next((path for path in map(shutil.which, programs) if path), None)
    if program:
        return Finding(name, "ok", program)
    return Finding(name, "warn", f"none found (optional): {', '.join(programs)}", fix)
