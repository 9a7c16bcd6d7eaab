"""Single bytes changed at random in a certificate and its run file, and what `verify` says."""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path

from helpers_cli import call
from helpers_workflow import quick_procedure, run

RUN_FILE = "run.h5"
ORDER = (
    "--customer=Example customer", "--customer-contact=2 Sample Road", "--item=Bearing",
    "--item-condition=as new", "--received=2026-02-27", "--authorised-by=Z. Head",
)  # fmt: skip
PLACES = ("changed at bytes", "/entry", "/ (file)", "the seal itself", "structure", "layout of")
"""Words by which `verify` locates a change."""


@dataclass(frozen=True)
class Flip:
    """One changed byte, and what `verify` reported."""

    file: str
    at: int
    bits: int
    code: int
    said: tuple[str, ...]

    @property
    def found(self) -> bool:
        """Whether the change was reported, without a traceback."""
        return self.code == 1 and bool(self.said)

    @property
    def placed(self) -> bool:
        """Whether the change was located."""
        return any(place in line for line in self.said for place in PLACES)


def quick_runs(folder: Path) -> Path:
    """Make a no-load run and a loaded one on the simulated rig, fewer and shorter than shipped."""
    for name in ("no_load_inertia_sweep", "starting_torque_1000n"):
        finished = run(quick_procedure(folder, name), folder / "runs")
        assert finished.error is None, finished.error
    return finished.folder


def letterhead(folder: Path) -> Path:
    """Make a lab folder, and return its letterhead."""
    initialised = call("init", folder)
    assert initialised.code == 0, initialised.err
    return folder / "letterhead"


def issue(run_folder: Path, letterhead: Path, out: Path, *more: str) -> list[Path]:
    """Issue a specimen; return its files."""
    done = call(
        "certify", run_folder, *ORDER, "--letterhead", letterhead, "--out", out,
        "--not-for-certification", *more,
    )  # fmt: skip
    assert done.code == 0, done.err
    return [Path(line) for line in done.out.splitlines()]


def flips(files: list[Path], run_folder: Path, scratch: Path, count: int, seed: int):
    """Yield `count` changes, spread evenly over the certificate's files and the run file."""
    rng = random.Random(seed)  # noqa: S311  (seeded, to be repeated)
    scratch.mkdir()
    originals = {path.name: path.read_bytes() for path in (*files, run_folder / RUN_FILE)}
    for name, content in originals.items():
        (scratch / name).write_bytes(content)
    certificate = next(path.name for path in files if path.suffix == ".json")
    for index in range(count):
        name = list(originals)[index % len(originals)]
        content = bytearray(originals[name])
        at, bits = rng.randrange(len(content)), rng.randrange(1, 256)
        content[at] ^= bits
        (scratch / name).write_bytes(content)
        done = call("verify", scratch / certificate)
        (scratch / name).write_bytes(originals[name])
        said = tuple(line for line in done.out.splitlines() if line.startswith("DIFFERS"))
        yield Flip(name, at, bits, done.code, said)
