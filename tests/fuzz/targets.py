"""What reads files of strangers, each with some good files to begin from.

A target takes a file that may hold anything; it may read it or raise a RigrunnerError, no more.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import h5py
import numpy as np

from helpers_runfile import DOCUMENT, PLOT, header_of, recording, write_run
from rigrunner.api.data import Block
from rigrunner.procedure import load_procedure
from rigrunner.runfile import read, read_info, read_truth
from rigrunner.runfile.codec import block_bytes, header_bytes
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import JournalWriter, Kind, read_records
from rigrunner.station import load_station
from rigrunner.workflow.inputs import read_answers
from rigrunner.workflow.locate import shipped_folder
from rigrunner_plugins.devices.replay.csv_file import read_csv
from rigrunner_plugins.devices.replay.hdf5_file import read_hdf5
from rigrunner_plugins.devices.replay.manifest import load_manifest
from rigrunner_plugins.devices.replay.settings import ColumnSettings, TableSettings

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigrunner.procedure import Procedure

CHANNELS = {
    "angle": ColumnSettings(column="angle", unit="deg"),
    "torque": ColumnSettings(column="torque", unit="N·m"),
}
MANIFEST = """rigrunner: replay/1
recordings:
  - {file: a.csv, frequency: 10 Hz, load: 1000 N}
  - {file: b.csv, frequency: 20 Hz, load: 0 N, values: {torque: 1.5 N·m}}
"""
ANSWERS = "specimen: SN-0042\noperator: 'Zoë'\n"


@dataclass(frozen=True)
class Target:
    """One reader of files."""

    name: str
    suffix: str
    seeds: Callable[[Path], list[bytes]]
    """Good files; given is an empty folder to make them in."""
    read: Callable[[Path], object]
    """Reads the file, which lies alone in a folder of its own."""


def _shipped(pattern: str) -> list[bytes]:
    return [path.read_bytes() for path in sorted(shipped_folder().glob(pattern))]


@cache
def _starting_torque() -> Procedure:
    return load_procedure(shipped_folder() / "starting_torque_1000n.yaml").model


def _answers(path: Path) -> object:
    return read_answers(path, _starting_torque())


def _csv(path: Path) -> object:
    return read_csv(path, {"angle": "angle", "torque": 2}, TableSettings())


def _csv_seeds(_: Path) -> list[bytes]:
    rows = "\n".join(f"{i / 7:.5f},{-i / 3:.4e}" for i in range(40))
    return [f"angle,torque\n{rows}\n".encode(), b"\xef\xbb\xbfangle,torque\r\n1,2\r\n"]


def _manifest(path: Path) -> object:
    for name in ("a.csv", "b.csv"):
        (path.parent / name).touch()
    return load_manifest(path.parent, path.name, CHANNELS)


def _hdf5(path: Path) -> object:
    return read_hdf5(path, {"angle": "angle", "torque": "torque"}, "/")


def _hdf5_seeds(folder: Path) -> list[bytes]:
    for name, filters in {
        "plain": {},
        "packed": {"compression": "gzip", "fletcher32": True},
    }.items():
        with h5py.File(folder / name, "w") as file:
            for channel in CHANNELS:
                file.create_dataset(channel, data=np.arange(300.0), **filters)
    return [(folder / "plain").read_bytes(), (folder / "packed").read_bytes()]


def _run(path: Path) -> object:
    return read_info(path), read(path), read_truth(path)


def _run_seeds(folder: Path) -> list[bytes]:
    writer = write_run(folder / "run", [recording(samples=200), recording("b", samples=150)])
    return [writer.seal(DOCUMENT, PLOT).read_bytes()]


def _journal(path: Path) -> object:
    """Read a run that is not sealed, with this file as its journal."""
    files = RunFolder(path.parent / "run")
    files.journal.mkdir(parents=True, exist_ok=True)
    shutil.copy(path, files.events)
    return read(files.path)


def _journal_seeds(folder: Path) -> list[bytes]:
    writer = write_run(folder / "run", [recording(samples=200)])
    return [RunFolder(writer.folder).events.read_bytes()]


def _record(path: Path) -> object:
    """Read a journal of one good header and one record whose checksum is right."""
    kind, payload = path.read_bytes()[:1], path.read_bytes()[1:]
    files = RunFolder(path.parent / "run")
    files.journal.mkdir(parents=True, exist_ok=True)
    files.events.unlink(missing_ok=True)
    journal = JournalWriter(files.events)
    journal.append(Kind.HEADER, header_bytes(header_of()))
    journal.append(Kind(1 + kind[0] % 3) if kind else Kind.EVENT, payload)
    journal.close()
    return read(files.path), read_truth(files.path)


def _record_seeds(folder: Path) -> list[bytes]:
    writer = write_run(folder / "run", [recording(samples=200)])
    records = read_records(RunFolder(writer.folder).events)
    return [bytes([each.kind - 1]) + each.payload for each in records]


def _block(path: Path) -> object:
    """Read a run that is not sealed, with this block among its samples; its checksum is right."""
    files = RunFolder(path.parent / "run")
    if not files.path.exists():
        write_run(files.path, [recording(samples=200)])
        files.part(1).unlink()
    files.samples(1).unlink(missing_ok=True)
    journal = JournalWriter(files.samples(1))
    for payload in (_good_block(), (path.read_bytes(),), _good_block()):
        journal.append(Kind.BLOCK, *payload)
    journal.close()
    return read(files.path)


def _good_block() -> tuple[bytes | memoryview, ...]:
    channels = {"tester.torque": np.arange(5.0), "tester.angle": np.ones(5)}
    return block_bytes("001_10Hz", Block(100.0, 0, 0.0, channels))


def _block_seeds(_: Path) -> list[bytes]:
    return [b"".join(_good_block())]


TARGETS = (
    Target("procedure", ".yaml", lambda _: _shipped("*.yaml"), load_procedure),
    Target("station", ".yaml", lambda _: _shipped("stations/*.yaml"), load_station),
    Target("answers", ".yaml", lambda _: [ANSWERS.encode()], _answers),
    Target("replay manifest", ".yaml", lambda _: [MANIFEST.encode()], _manifest),
    Target("replay csv", ".csv", _csv_seeds, _csv),
    Target("replay hdf5", ".h5", _hdf5_seeds, _hdf5),
    Target("run file", ".h5", _run_seeds, _run),
    Target("journal", ".journal", _journal_seeds, _journal),
    Target("journal record", ".record", _record_seeds, _record),
    Target("journal block", ".block", _block_seeds, _block),
)
