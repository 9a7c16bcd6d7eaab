"""`rigrunner analyse` of recordings of increasing length: time per sample, and memory.

A run of five set-points at 100 kS/s on the simulated rig, three channels each (angle, torque and
one more); the fourth set-point, 25 Hz, is long. The whole command is measured in a separate
process, including start-up and imports: its processor time, and its peak memory (`ru_maxrss`). Each
recording is 16-bit data of a real signal chain, repeated, in a file as a run leaves it. Successive
sizes alternate, and each turn gives the time per further sample from one size to the next. Its
ratio to the smallest such time of the sizes before shows the growth: 1 is linear.

Up to an hour, 1.08 x 10^9 samples, here; `python tests/benchmarks/long_recording.py HOURS` takes
any length.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain, pairwise, repeat
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks.frame import Figure, Spread, Work, allocated_peak, at_most
from helpers_long import short_cycles
from helpers_workflow import quick_procedure, run, station_file
from rigrunner.procedure import parse_procedure
from rigrunner.run.stored import run_data
from rigrunner.runfile import read
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.loose import PART_GROUP
from rigrunner.runfile.recordings import read_facts
from rigrunner.signal.blocks import BLOCK
from rigrunner_bearings.torque import waveforms
from rigrunner_bearings.torque.prepare import prepare_point
from rigrunner_bearings.torque.settings import SwingTorque
from unit.runfile.helpers_runfile import write_run

if TYPE_CHECKING:
    from benchmarks.frame import Scale
    from rigrunner.api.data import Array, Recording
    from rigrunner.runfile import StoredRun

RATE_HZ = 100_000
CHANNELS = 3
LONG_HZ = 25.0
FREQUENCY = "tester.frequency"
PATTERN = 8 * 4000
PERIOD = 64 * PATTERN
"""Samples after which cycles and chunks of a file coincide again."""
HOUR = 3600 * RATE_HZ * CHANNELS
SIZES = (100_000, 1_000_000, 10_000_000, 100_000_000, HOUR)
MEMORY_MB = 500
LAUNCHER = """
import os, subprocess, sys
process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
_, status, used = os.wait4(process.pid, 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)
"""
"""A small process that starts the command: the peak memory of a process includes its parent's."""
AT_ONCE = 200_000
FEW = 200_000
LINEAR = at_most(1.25)
LIMIT = "a third is gzip and SHA-256, a third splines onto the crank phase, a tenth running medians"
NOTES = (
    "up to 64 MB are read into memory: unpacked once",
    "beyond, what is analysed is unpacked twice: for its digest, and to be kept on disk",
)


@dataclass(frozen=True, eq=False)
class Repeated:
    """Repeated samples of shape (count,), made only by slices."""

    pattern: Array
    count: int

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, indices: slice) -> Array:
        begin, end, _ = indices.indices(self.count)
        first, period = begin % len(self.pattern), len(self.pattern)
        last = first + end - begin
        return np.tile(self.pattern, -(-last // period))[first:last]


@cache
def short_runs() -> tuple[StoredRun, Path]:
    """Return a loaded run of 12 cycles at each of five frequencies, and its no-load run."""
    folder = Path(tempfile.mkdtemp())
    changes = ("settings: {seed: 1}", "settings: {seed: 1, sensors: {rate: 100 kHz}}")
    station = station_file(folder, changes)
    runs = folder / "runs"
    no_load = run(quick_procedure(folder, "no_load_inertia_sweep"), runs, station=station)
    loaded = run(quick_procedure(folder, "starting_torque_1000n"), runs, station=station)
    return read(loaded.folder), no_load.folder


def long_run(folder: Path, samples: int) -> None:
    """Write an unsealed run with this number of samples per channel in the long recording."""
    stored, _ = short_runs()
    recordings = [with_third(recording) for recording in stored.recordings]
    index = [recording.setpoints[FREQUENCY] for recording in recordings].index(LONG_HZ)
    recordings[index] = repeated(recordings[index], min(samples, PERIOD))
    write_run(folder, recordings, header=stored.header, block=AT_ONCE)
    if samples > PERIOD:
        files = RunFolder(folder)
        lengthen(files.finished_parts()[index], repeated(recordings[index], samples))


def with_third(recording: Recording) -> Recording:
    force = np.round(1000 + recording.arrays()["tester.torque"])
    channels = {**recording.arrays(), "tester.force": force}
    return replace(recording, channels=channels, units={**recording.units, "tester.force": "N"})


def repeated(recording: Recording, samples: int) -> Recording:
    """Return a recording that repeats its first eight cycles."""
    patterns = {name: values[:PATTERN] for name, values in recording.channels.items()}
    channels = {name: Repeated(values, samples) for name, values in patterns.items()}
    return replace(recording, channels=channels)


def lengthen(part: Path, recording: Recording) -> None:
    """Lengthen a recording of one PERIOD by repeating its packed chunks.

    This saves packing hours of samples. The time column, which no analysis reads, is empty.
    """
    longer = part.with_suffix(".longer")
    with h5py.File(part, "r") as old, h5py.File(longer, "w", libver=("earliest", "v110")) as new:
        source = old[PART_GROUP]
        group = new.create_group(PART_GROUP)
        digest = replace(read_facts(source), samples=recording.samples).digest()
        for name, item in source.items():
            if isinstance(item, h5py.Group):
                source.copy(name, group)
            else:
                _lengthen_column(item, group, name, recording.samples)
        for at in range(0, recording.samples, BLOCK):
            digest.update({n: values[at : at + BLOCK] for n, values in recording.channels.items()})
        group.attrs.update(source.attrs)
        group.attrs["samples"], group.attrs["sha256"] = recording.samples, digest.hexdigest()
    part.unlink()
    longer.rename(part)


def _lengthen_column(item: h5py.Dataset, group: h5py.Group, name: str, samples: int) -> None:
    settings = {"chunks": item.chunks, "compression": "gzip", "compression_opts": 1}
    column = group.create_dataset(
        name, (samples,), "<f8", shuffle=True, fletcher32=True, **settings
    )
    column.attrs.update(item.attrs)
    (chunk,) = item.chunks
    packed = [item.id.read_direct_chunk((offset,)) for offset in range(0, len(item), chunk)]
    for offset in range(0, samples if "column" in item.attrs else 0, chunk):
        mask, data = packed[offset // chunk % len(packed)]
        column.id.write_direct_chunk((offset,), data, mask)


def analysed(folder: Path) -> tuple[float, float]:
    """Return the processor time of the command in s, and its peak memory in MB."""
    _, no_load = short_runs()
    command = [sys.executable, "-m", "rigrunner", "analyse", str(folder), "--json"]
    command += ["--no-load", str(no_load)]
    launcher = [sys.executable, "-c", LAUNCHER, *command]
    output = subprocess.run(launcher, capture_output=True, text=True, check=True).stdout
    code, seconds, memory = map(float, output.split())
    assert code in {0, 1, 10}, code  # whatever the verdict
    return seconds, memory


def measure(scale: Scale) -> list[Figure]:
    return figures(SIZES[:1] if scale.short else SIZES)


def figures(sizes: tuple[int, ...]) -> list[Figure]:
    """Return time and memory of each size, and the time per further sample."""
    measured: dict[int, list[tuple[float, float]]] = {samples: [] for samples in sizes}
    with tempfile.TemporaryDirectory() as name:
        folders = {samples: Path(name) / str(samples) for samples in sizes}
        for samples, folder in folders.items():
            long_run(folder, samples // CHANNELS)
        for group in [*pairwise(sizes)] or [sizes]:
            for _ in range(turns(max(group)) if group[1:] else 1):  # a single size has no turns
                for samples in group:
                    measured[samples].append(analysed(folders[samples]))
    return [figure for size in measured.items() for figure in per_size(*size)] + growth(measured)


def turns(samples: int) -> int:
    """Return the number of turns of a size: small sizes differ little and need more."""
    return max(1, min(9, round(3e8 / samples)))


def per_size(samples: int, measured: list[tuple[float, float]]) -> list[Figure]:
    what = f"{samples:.3g} samples, {samples / CHANNELS / RATE_HZ:.4g} s"
    seconds, memory = (Spread.of(values) for values in zip(*measured, strict=True))
    return [
        Figure(f"time, {what}", seconds, "s"),
        Figure(f"memory, {what}", memory, "MB", target=at_most(MEMORY_MB, "MB")),
    ]


def growth(measured: dict[int, list[tuple[float, float]]]) -> list[Figure]:
    """Return the time of each further sample, from one size to the next."""
    figures: list[Figure] = []
    least = inf
    for (few, many), note in zip(pairwise(measured), chain(NOTES, repeat(LIMIT)), strict=False):
        count = turns(many)  # the last turns of the smaller size, the first of the larger
        times = zip(measured[few][-count:], measured[many][:count], strict=True)
        each_ns = Spread.of((b - a) / (many - few) * 1e9 for (a, _), (b, _) in times)
        what, ratio = f"each further sample, {few:.3g} to {many:.3g}", each_ns.per(least)
        target = LINEAR if figures else None
        figures.append(
            Figure(what, each_ns, "ns", ratio=ratio if figures else None, target=target, note=note)
        )
        least = min(least, each_ns.median)
    return figures


def work() -> list[Work]:
    """Return the growth of memory with the length, counted with blocks of a tenth."""
    with pytest.MonkeyPatch.context() as patch:
        short_cycles(patch, FEW)
        patch.setattr(waveforms, "MOST_ROWS", 64)
        two_blocks, four_blocks = (_peak_bytes(count * FEW) for count in (2, 4))
    return [
        Work("bytes for a sample of a block, at most at once", two_blocks / FEW, 110),
        Work("the same of four blocks, over that of two", four_blocks / two_blocks, 1.1),
    ]


def _peak_bytes(samples: int) -> float:
    stored, _ = short_runs()
    (long,) = (r for r in stored.recordings if r.setpoints[FREQUENCY] == LONG_HZ)
    longer = repeated(with_third(long), samples)
    data = run_data(stored)
    (settings,) = parse_procedure(stored.header.procedure_text, "").model.analysis
    spec = SwingTorque.model_validate(settings.settings)
    return allocated_peak(lambda: prepare_point(longer, data, spec, lambda _: []))


if __name__ == "__main__":
    hours = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    for figure in figures((*SIZES[2:4], round(hours * HOUR))):
        sys.stdout.write(f"{figure.what}: {figure.value.median:.4g} {figure.unit}\n")
