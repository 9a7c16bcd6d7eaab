"""Small run folders for archives, and a PostgreSQL server."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from helpers_lacking import lacking
from rigrunner.runfile import seal
from unit.runfile.helpers_runfile import header_of, recording, write_run

if TYPE_CHECKING:
    from collections.abc import Iterator

NOBODY = 65534
_NUMBERS = count(1)


def estimate(value: float | None, u: float = 0.005, unit: str = "N·m") -> dict:
    return {
        "value": value,
        "standard_uncertainty": u,
        "degrees_of_freedom": "infinite",
        "coverage_factor_95": 2.0,
        "expanded_uncertainty_95": 2 * u,
        "unit": unit,
    }


def result_document(torque_nm: float = 0.72, verdict: str = "pass", **changed: object) -> dict:
    """Return the part of a `result.json` that an archive reads, with two set-points."""
    frequencies = (10.0, 20.0)
    document = {
        "format": "rigrunner: result/1",
        "measurand": {"symbol": "Td", "name": "load-induced starting torque", "unit": "N·m"},
        "run": {"mandrel": "M-01"},
        "no_load_run": {"id": "no-load"},
        "headline": {
            "method": "template_inverse",
            "compensated": estimate(torque_nm),
            "raw_peak": estimate(3.7),
        },
        "decision": {
            "verdict": verdict,
            "reason": "within the limit",
            "rule": "guard_band_u: words",
            "limit": "≤ 0.95 N·m",
            "limit_source": "a drawing",
            "probability_of_conformity": 0.99,
        },
        "checks": [{"name": "a", "ok": True}, {"name": "b", "ok": False}],
        "points": [_point(number, hz) for number, hz in enumerate(frequencies, 1)],
        "compensations": {
            "template_inverse": {
                "checks": [{"name": "c", "ok": False}],
                "parameters": {"inertia": estimate(0.00232, 1e-6, "kg·m²")},
                "points": [
                    {**_frequencies(hz), "torque": estimate(torque_nm + hz / 1000)}
                    for hz in frequencies
                ],
            }
        },
        "fits": [
            {
                "name": "polynomial",
                "curve": {
                    "coefficients": {"c0": estimate(0.9, 0.1)},
                    "degrees_of_freedom": 9.0,
                },
            }
        ],
    }  # fmt: skip
    return document | changed


def store_run(
    runs: Path, name: str = "", document: object = None, *, recordings: int = 1, **header: object
) -> Path:
    """Write and seal a small run; its inputs are those of the header.

    Without a recording it takes a third less time, if only the result is needed.
    """
    number = next(_NUMBERS)
    folder = runs / (name or f"run-{number}")
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir()
    run_header = header_of(folder.name, **header)
    write_run(folder, [recording(samples=50, seed=number)] * recordings, header=run_header)
    seal(folder, result_document() if document is None else document)
    return folder


def _frequencies(frequency_hz: float) -> dict:
    return {
        "set_frequency": {"value": frequency_hz, "unit": "Hz"},
        "frequency": {"value": frequency_hz * 1.0001, "unit": "Hz"},
    }


def _point(number: int, frequency_hz: float) -> dict:
    return {
        "recording": f"{number:03d}",
        **_frequencies(frequency_hz),
        "load": {"value": 1000.5, "unit": "N"},
        "raw_peak": {
            "mean": {"value": 2.0 + number, "unit": "N·m"},
            "standard_deviation": {"value": 0.01, "unit": "N·m"},
            "cycles_kept": 30,
        },
    }


@contextmanager
def postgresql_server() -> Iterator[str]:
    """Run a PostgreSQL server with its socket in a folder; yield the end of its URL."""
    programs = _programs()
    if programs is None:
        lacking("POSTGRES", "there is no PostgreSQL here")
    folder = Path(tempfile.mkdtemp(prefix="pg", dir="/tmp"))
    user = _user(folder)
    data = folder / "data"
    options = f"-c listen_addresses='' -c unix_socket_directories={folder} -c fsync=off"
    try:
        _run([programs / "initdb", "-D", data, "-A", "trust", "-U", "rigrunner", "-N"], user)
        start = [programs / "pg_ctl", "-D", data, "-w", "-l", folder / "log", "-o", options]
        _run([*start, "start"], user)
        try:
            yield f"?host={folder}"
        finally:
            _run([programs / "pg_ctl", "-D", data, "-m", "immediate", "stop"], user)
    finally:
        shutil.rmtree(folder)


def has_postgresql() -> bool:
    return _programs() is not None


def _programs() -> Path | None:
    """Return the folder of PostgreSQL's programs: Debian keeps them off the path."""
    initdb = shutil.which("initdb")
    places = [Path(initdb).parent] if initdb else Path("/usr/lib/postgresql").glob("*/bin")
    return max((folder for folder in places if (folder / "initdb").exists()), default=None)


def _user(folder: Path) -> dict[str, object]:
    """Return the user for PostgreSQL, which refuses to run as root, and give it the folder."""
    if os.geteuid() != 0:
        return {}
    os.chown(folder, NOBODY, NOBODY)
    return {"user": NOBODY, "group": NOBODY, "extra_groups": []}


def _run(command: list[object], user: dict[str, object]) -> None:
    process = subprocess.run(
        [str(argument) for argument in command],
        cwd="/",
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
        **user,
    )
    assert process.returncode == 0, process.stdout.decode()
