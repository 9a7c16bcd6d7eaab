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
"""The words with which `verify` names the place."""


@dataclass(frozen=True)
class Flip:
    """One changed byte, and the reported differences."""

    file: str
    at: int
    bits: int
    code: int
    differences: tuple[str, ...]

    @property
    def found(self) -> bool:
        """Whether a difference was reported, without a traceback."""
        return self.code == 1 and bool(self.differences)

    @property
    def placed(self) -> bool:
        """Whether the place was reported."""
        return any(place in line for line in self.differences for place in PLACES)


def quick_runs(folder: Path) -> Path:
    """Make a no-load run and a loaded one on the simulated rig, fewer and shorter than shipped."""
    for name in ("no_load_inertia_sweep", "starting_torque_1000n"):
        finished = run(quick_procedure(folder, name), folder / "runs")
        assert finished.error is None, finished.error
    return finished.folder


def letterhead(folder: Path) -> Path:
    """Make a lab folder, and return its letterhead."""
    result = call("init", folder)
    assert result.code == 0, result.err
    return folder / "letterhead"


def issue(run_folder: Path, letterhead: Path, out: Path, *more: str) -> list[Path]:
    """Issue a specimen; return its files."""
    result = call(
        "certify", run_folder, *ORDER, "--letterhead", letterhead, "--out", out,
        "--not-for-certification", *more,
    )  # fmt: skip
    assert result.code == 0, result.err
    return [Path(line) for line in result.out.splitlines()]


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
        offset, bits = rng.randrange(len(content)), rng.randrange(1, 256)
        content[offset] ^= bits
        (scratch / name).write_bytes(content)
        result = call("verify", scratch / certificate)
        (scratch / name).write_bytes(originals[name])
        differences = tuple(line for line in result.out.splitlines() if line.startswith("DIFFERS"))
        yield Flip(name, offset, bits, result.code, differences)
