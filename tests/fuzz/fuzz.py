"""Feeds every reader of files with nearly good ones: `python tests/fuzz/fuzz.py --inputs 20000`.

Prints a table of what became of them. A reader may read a file or refuse it with a RigrunnerError,
within ten seconds; whatever else happens is a crash, and its file is kept in the folder `--out`,
from where it goes to tests/fuzz/corpus once it is fixed. The readers run in a process of their
own, so that one that brings it down is seen too. The same seed gives the same files.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import traceback
import warnings
import zlib
from collections import Counter
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from mutate import mutated
from targets import TARGETS, Target

from rigrunner.api.errors import RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from multiprocessing.connection import Connection

PATIENCE_S = 10.0
READ, REFUSED, CRASHED, DIED, HUNG = "read", "refused", "crashed", "died", "hung"
GOOD = (READ, REFUSED)
READY = "ready"


@dataclass
class Tally:
    """What became of the files of one target."""

    counts: Counter[str] = field(default_factory=Counter)
    crashes: dict[str, bytes] = field(default_factory=dict)
    """One file for each place in the code."""


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


def seeds_of(target: Target) -> list[bytes]:
    """Return the good files of a target."""
    with tempfile.TemporaryDirectory() as folder:
        return target.seeds(Path(folder))


def _serve(pipe: Connection) -> None:
    targets = {each.name: each for each in TARGETS}
    pipe.send(READY)  # its own start does not count as reading, however slow the machine is
    with tempfile.TemporaryDirectory() as folder:
        while True:
            name, data = pipe.recv()
            own = Path(folder) / name  # what a target lays beside its files is not another's
            own.mkdir(exist_ok=True)
            pipe.send(verdict(targets[name], data, own))


class Reader:
    """The process that reads; begun anew whenever a file was too much for it."""

    def __init__(self) -> None:
        self._begin()

    def __call__(self, target: Target, data: bytes) -> tuple[str, str]:
        self._pipe.send((target.name, data))
        try:
            if self._pipe.poll(PATIENCE_S):
                return self._pipe.recv()
            outcome = HUNG
        except EOFError:
            outcome = DIED
        self.end()
        self._begin()
        return outcome, outcome

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
        outcome, where = reader(target, data)
        tally.counts[outcome] += 1
        if outcome not in GOOD:
            tally.crashes.setdefault(where, data)
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
    header = ("reader", "files", READ, REFUSED, CRASHED, DIED, HUNG)
    sys.stdout.write(f"| {' | '.join(header)} |\n|{' --- |' * len(header)}\n")
    bad, reader = 0, Reader()
    for target in TARGETS:
        if given.only in (None, target.name):
            tally = fuzz(reader, target, given.inputs, given.seed)
            _keep(target, tally, given.out)
            counts = [tally.counts[name] for name in header[2:]]
            bad += sum(counts[2:])
            row = (target.name, given.inputs, *counts)
            sys.stdout.write(f"| {' | '.join(map(str, row))} |\n")
            for where in tally.crashes:
                sys.stderr.write(f"  {target.name}: {where}\n")
            sys.stdout.flush()
    reader.end()
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
