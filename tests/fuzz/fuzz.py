"""Feeds every reader of files with nearly good ones: `python tests/fuzz/fuzz.py --inputs 20000`.

Prints a table of what became of them, and what it took. A reader may read a file or refuse it with
a RigrunnerError, within a second of the processor and ten seconds by the clock, and may change no
file elsewhere; whatever else happens is a fault, and its file is kept in the folder `--out`, from
where it goes to tests/fuzz/corpus once it is fixed. The readers run in a process of their own, so
that one that brings it down is seen too. The same seed gives the same files.
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
"""Of the processor, which a busy machine does not lengthen much."""
READ, REFUSED, CRASHED, DIED, HUNG = "read", "refused", "crashed", "died", "hung"
SLOW, ELSEWHERE = "slow", "elsewhere"
OUTCOMES = (READ, REFUSED, CRASHED, DIED, HUNG, SLOW, ELSEWHERE)
GOOD = (READ, REFUSED)
READY = "ready"


@dataclass
class Tally:
    """What became of the files of one target."""

    counts: Counter[str] = field(default_factory=Counter)
    crashes: dict[str, bytes] = field(default_factory=dict)
    """One file for each place in the code."""
    began: float = field(default_factory=time.monotonic)
    processor_s: float = 0.0
    slowest_s: float = 0.0
    peaks_mb: list[float] = field(default_factory=list)
    """Of the reader's memory, after each file."""

    def row(self, target: Target) -> tuple[str, ...]:
        counts = [self.counts[name] for name in OUTCOMES]
        early, late = self.peaks_mb[len(self.peaks_mb) // 10], self.peaks_mb[-1]
        took = (f"{time.monotonic() - self.began:.0f}", f"{self.processor_s:.0f}")
        return (
            target.name, *map(str, (sum(counts), *counts)), *took, f"{1000 * self.slowest_s:.0f}",
            f"{early:.0f} to {late:.0f}",
        )  # fmt: skip


HEADER = (
    "reader", "files", *OUTCOMES, "s by the clock", "s of the reader's processor",
    "ms of the slowest", "MB at most, after a tenth and at the end",
)  # fmt: skip


class Measured(NamedTuple):
    """What became of one file, and what it took."""

    outcome: str
    where: str = ""
    processor_s: float = 0.0
    peak_mb: float = 0.0


def verdict(target: Target, data: bytes, folder: Path) -> tuple[str, str]:
    """Return what becomes of one file, and where in the code if it crashed."""
    path = folder / f"file{target.suffix}"
    path.write_bytes(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            target.read(path)
    except RigrunnerError:
        return REFUSED, ""
    except Exception as error:  # noqa: BLE001  (that is what is looked for)
        last = traceback.extract_tb(error.__traceback__)[-1]
        return CRASHED, f"{type(error).__name__} at {Path(last.filename).name}:{last.lineno}"
    return READ, ""


def measured(target: Target, data: bytes, folder: Path, changes: list[str]) -> Measured:
    """Return the verdict on one file, with what it took; what was slow is read again.

    The first file makes a reader import what it needs.
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
    """Return the good files of a target."""
    with tempfile.TemporaryDirectory() as folder:
        return target.seeds(Path(folder))


def _serve(pipe: Connection) -> None:
    targets = {each.name: each for each in TARGETS}
    sys.dont_write_bytecode = True  # of what is imported later
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        tempfile.tempdir = folder
        changes = watch(Path(folder))
        pipe.send(READY)  # its own start does not count as reading, however slow the machine is
        while True:
            name, data = pipe.recv()
            own = Path(folder) / name  # what a target lays beside its files is not another's
            own.mkdir(exist_ok=True)
            pipe.send(measured(targets[name], data, own, changes))


class Reader:
    """The process that reads; begun again whenever a file was too much for it."""

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
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,))
        self._process.start()
        theirs.close()
        if self._pipe.recv() != READY:
            raise RuntimeError("the process that reads did not begin")


def fuzz(reader: Reader, target: Target, inputs: int, seed: int) -> Tally:
    """Read so many files and return what became of them."""
    tally, seeds = Tally(), seeds_of(target)
    for number in range(inputs):
        rng = np.random.default_rng([seed, zlib.crc32(target.name.encode()), number])
        data = mutated(seeds, rng)
        found = reader(target, data)
        tally.counts[found.outcome] += 1
        tally.processor_s += found.processor_s
        tally.slowest_s = max(tally.slowest_s, found.processor_s)
        tally.peaks_mb.append(found.peak_mb)
        if found.outcome not in GOOD:
            tally.crashes.setdefault(found.where, data)
    return tally


def _keep(target: Target, tally: Tally, out: Path) -> None:
    for where, data in tally.crashes.items():
        name = f"{target.name} {where}".replace(" ", "_").replace(":", "_").replace("/", "_")
        out.mkdir(parents=True, exist_ok=True)
        (out / f"{name}{target.suffix}").write_bytes(data)


def main(arguments: Sequence[str] | None = None) -> int:
    """Fuzz all targets, or the one named; return 1 where anything crashed."""
    parser = argparse.ArgumentParser(description="Feeds every reader with nearly good files.")
    parser.add_argument("--inputs", type=int, default=2000, help="files for each reader")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=[each.name for each in TARGETS])
    parser.add_argument("--out", type=Path, default=Path("fuzz-crashes"))
    given = parser.parse_args(arguments)
    sys.stdout.write(f"| {' | '.join(HEADER)} |\n|{' --- |' * len(HEADER)}\n")
    bad, reader = 0, Reader()
    for target in TARGETS:
        if given.only in (None, target.name):
            tally = fuzz(reader, target, given.inputs, given.seed)
            _keep(target, tally, given.out)
            bad += given.inputs - sum(tally.counts[name] for name in GOOD)
            sys.stdout.write(f"| {' | '.join(tally.row(target))} |\n")
            for where in tally.crashes:
                sys.stderr.write(f"  {target.name}: {where}\n")
            sys.stdout.flush()
    reader.end()
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
