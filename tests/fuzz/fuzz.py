"""Fuzz every file reader with slightly broken files: `python tests/fuzz/fuzz.py --inputs 20000`.

Prints a table of outcomes and times. A reader may read a file or refuse it with a RigrunnerError,
within a second of processor time and ten seconds of wall-clock time, and may change no other file.
Anything else is a bug; its file is saved in the folder `--out`, and moved to tests/fuzz/corpus once
the bug is fixed. The readers run in a separate process, so that crashes of the interpreter are
found too. The same seed gives the same files.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
import traceback
import warnings
import zlib
from collections import Counter
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from mutate import mutated
from targets import TARGETS, Target
from watch import watch

from rigrunner.api.errors import RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from multiprocessing.connection import Connection

PATIENCE_S = 10.0
SLOW_S = 1.0
"""Processor time, which depends little on the load of the machine."""
READ, REFUSED, CRASHED, DIED, HUNG = "read", "refused", "crashed", "died", "hung"
SLOW, ELSEWHERE = "slow", "elsewhere"
OUTCOMES = (READ, REFUSED, CRASHED, DIED, HUNG, SLOW, ELSEWHERE)
GOOD = (READ, REFUSED)
READY = "ready"


@dataclass
class Tally:
    """The outcomes of the files of one target."""

    counts: Counter[str] = field(default_factory=Counter)
    crashes: dict[str, bytes] = field(default_factory=dict)
    """One file for each crashing line of code."""
    began: float = field(default_factory=time.monotonic)
    processor_s: float = 0.0
    slowest_s: float = 0.0
    peaks_mb: list[float] = field(default_factory=list)
    """Peak memory of the reader after each file."""

    def row(self, target: Target) -> tuple[str, ...]:
        counts = [self.counts[name] for name in OUTCOMES]
        early, late = self.peaks_mb[len(self.peaks_mb) // 10], self.peaks_mb[-1]
        times = (f"{time.monotonic() - self.began:.0f}", f"{self.processor_s:.0f}")
        return (
            target.name, *map(str, (sum(counts), *counts)), *times, f"{1000 * self.slowest_s:.0f}",
            f"{early:.0f} to {late:.0f}",
        )  # fmt: skip


HEADER = (
    "reader", "files", *OUTCOMES, "s by the clock", "s of the reader's processor",
    "ms of the slowest", "MB at most, after a tenth and at the end",
)  # fmt: skip


class Measured(NamedTuple):
    """The outcome of one file, and its processor time and memory."""

    outcome: str
    where: str = ""
    processor_s: float = 0.0
    peak_mb: float = 0.0


def verdict(target: Target, data: bytes, folder: Path) -> tuple[str, str]:
    """Return the outcome of one file, and the line of code of a crash."""
    path = folder / f"file{target.suffix}"
    path.write_bytes(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            target.read(path)
    except RigrunnerError:
        return REFUSED, ""
    except Exception as error:  # noqa: BLE001  (these are the bugs to find)
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return CRASHED, f"{type(error).__name__} at {Path(frame.filename).name}:{frame.lineno}"
    return READ, ""


def measured(target: Target, data: bytes, folder: Path, changes: list[str]) -> Measured:
    """Return the outcome of one file with its cost. A slow file is read twice.

    The first file includes the imports of a reader.
    """
    for _ in range(2):
        began = time.process_time()
        outcome, where = verdict(target, data, folder)
        took_s = time.process_time() - began
        if took_s <= SLOW_S:
            break
    if outcome in GOOD and took_s > SLOW_S:
        outcome, where = SLOW, SLOW
    if changes:
        outcome, where = ELSEWHERE, changes[0]
        changes.clear()
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return Measured(outcome, where, took_s, peak_mb)


def seeds_of(target: Target) -> list[bytes]:
    """Return the valid files of a target."""
    with tempfile.TemporaryDirectory() as folder:
        return target.seeds(Path(folder))


def _serve(pipe: Connection) -> None:
    targets = {target.name: target for target in TARGETS}
    sys.dont_write_bytecode = True  # for later imports
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        tempfile.tempdir = folder
        changes = watch(Path(folder))
        pipe.send(READY)  # starting up does not count as reading
        while True:
            name, data = pipe.recv()
            target_folder = Path(folder) / name  # targets write other files beside their own
            target_folder.mkdir(exist_ok=True)
            pipe.send(measured(targets[name], data, target_folder, changes))


class Reader:
    """The process that reads; restarted after a file that killed it or hung."""

    def __init__(self) -> None:
        self._begin()

    def __call__(self, target: Target, data: bytes) -> Measured:
        self._pipe.send((target.name, data))
        try:
            if self._pipe.poll(PATIENCE_S):
                return self._pipe.recv()
            outcome = HUNG
        except EOFError:
            outcome = DIED
        self.end()
        self._begin()
        return Measured(outcome, outcome)

    def end(self) -> None:
        self._process.kill()
        self._process.join()

    def _begin(self) -> None:
        context = get_context("spawn")
        self._pipe, child_pipe = context.Pipe()
        self._process = context.Process(target=_serve, args=(child_pipe,))
        self._process.start()
        child_pipe.close()
        if self._pipe.recv() != READY:
            raise RuntimeError("the reading process did not start")


def fuzz(reader: Reader, target: Target, inputs: int, seed: int) -> Tally:
    """Read this number of files and return their outcomes."""
    tally, seeds = Tally(), seeds_of(target)
    for number in range(inputs):
        rng = np.random.default_rng([seed, zlib.crc32(target.name.encode()), number])
        data = mutated(seeds, rng)
        result = reader(target, data)
        tally.counts[result.outcome] += 1
        tally.processor_s += result.processor_s
        tally.slowest_s = max(tally.slowest_s, result.processor_s)
        tally.peaks_mb.append(result.peak_mb)
        if result.outcome not in GOOD:
            tally.crashes.setdefault(result.where, data)
    return tally


def _keep(target: Target, tally: Tally, out: Path) -> None:
    for where, data in tally.crashes.items():
        name = f"{target.name} {where}".replace(" ", "_").replace(":", "_").replace("/", "_")
        out.mkdir(parents=True, exist_ok=True)
        (out / f"{name}{target.suffix}").write_bytes(data)


def main(arguments: Sequence[str] | None = None) -> int:
    """Fuzz all targets or one; return 1 if any reader failed."""
    parser = argparse.ArgumentParser(description="Fuzzes every file reader.")
    parser.add_argument("--inputs", type=int, default=2000, help="files for each reader")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=[target.name for target in TARGETS])
    parser.add_argument("--out", type=Path, default=Path("fuzz-crashes"))
    options = parser.parse_args(arguments)
    sys.stdout.write(f"| {' | '.join(HEADER)} |\n|{' --- |' * len(HEADER)}\n")
    bad, reader = 0, Reader()
    for target in TARGETS:
        if options.only in (None, target.name):
            tally = fuzz(reader, target, options.inputs, options.seed)
            _keep(target, tally, options.out)
            bad += options.inputs - sum(tally.counts[name] for name in GOOD)
            sys.stdout.write(f"| {' | '.join(tally.row(target))} |\n")
            for where in tally.crashes:
                sys.stderr.write(f"  {target.name}: {where}\n")
            sys.stdout.flush()
    reader.end()
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
