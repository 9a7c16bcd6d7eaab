"""The machine, its load and the versions that a figure depends on."""

from __future__ import annotations

import os
import platform
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import h5py

ROOT = Path(__file__).resolve().parents[2]


def versions() -> str:
    """Return the line above the tables."""
    return (
        f"Measured {now()}: commit {commit()}, "
        f"Python {platform.python_version()}, numpy {version('numpy')}, "
        f"h5py {version('h5py')}, HDF5 {h5py.version.hdf5_version}, {platform.system()} "
        f"{platform.release()}, {cpu()}, {os.cpu_count()} cores, load {load()} at the start."
    )


def now() -> str:
    return f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"


def load() -> str:
    return f"{os.getloadavg()[0]:.1f}"


def commit() -> str:
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude=*"]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    return process.stdout.strip() or "unknown"


def cpu() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or "unknown processor"
    names = [line.partition(":")[2] for line in text.splitlines() if line.startswith("model name")]
    return " ".join(names[0].split()) if names else platform.machine()
