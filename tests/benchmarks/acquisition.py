"""Four channels at 1 MS/s each, 32 MB/s: recorded completely, analysed live, and compressed.

Flat out: the engine records a stream that delivers each block on request, checks it, and writes it
to the journal. The floor writes the same blocks with a CRC-32 to a file, in turn with ours; both
sync once a second and at the end.

Sustained: the panel runs the shipped analysis with a device that makes its samples in real time,
and loses them when more than a second of them has not been fetched. Panel, run and analyst are
separate processes, as always; a client follows the panel as a screen does. Behind is the time from
when a block is available until it is fetched. The pause is the time from the last block of a
recording to the next step. Memory is the resident memory of the process; its growth is that from
the middle third of the second recording to its last. The live torque is that of the latest cycles;
the analyst first prepares the no-load run. The age of a swing is that of its last sample when the
panel draws it.

Filters: one second of the four channels, from a 16-bit converter, as float64, written to HDF5.
"""

from __future__ import annotations

import os
import struct
import tempfile
import threading
import time
import zlib
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import h5py

from benchmarks import sustained
from benchmarks.fast_tester import FastTester, FastTesterSettings
from benchmarks.frame import (
    Figure,
    Scale,
    Work,
    allocated_peak,
    at_least,
    calls,
    pair_of,
    repeated,
)
from helpers_devices import plan_of, record
from rigrunner.api.devices import DeviceContext
from rigrunner.api.events import StepEnded, StepStarted
from rigrunner.bus import Bus
from rigrunner.clock import WallClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.rig import Rig
from rigrunner.runfile import RunWriter, read
from unit.runfile.helpers_runfile import header_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy as np

    from rigrunner.api.events import Event

RATE_HZ, BLOCK = 1e6, 100_000
CHANNELS = ("angle", "torque", "velocity", "load")
UNITS = {"tester.angle": "rad", "tester.torque": "N·m"}
BYTES = 8 * len(CHANNELS)
MB = 1e6
FILTERS: Mapping[str, Mapping[str, object]] = {
    "none": {},
    "shuffle, gzip 1, fletcher32": {
        "shuffle": True, "compression": "gzip", "compression_opts": 1, "fletcher32": True,
    },
    "shuffle, gzip 4": {"shuffle": True, "compression": "gzip", "compression_opts": 4},
    "shuffle, lzf": {"shuffle": True, "compression": "lzf"},
}  # fmt: skip
OURS = "shuffle, gzip 1, fletcher32"


def measure(scale: Scale) -> list[Figure]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return [
            *flat_out(folder, scale.of(10, 1), times=scale.of(9, 1)),
            *([] if scale.short else sustained.figures(folder / "lab", seconds=30)),
            *filters(folder / "filtered.h5", times=scale.of(5, 1)),
        ]


class Timer:
    """Records when a recording began and when its step ended."""

    def __init__(self) -> None:
        self.began_s = self.ended_s = 0.0

    def __call__(self, event: Event) -> None:
        if isinstance(event, StepStarted) and event.recording:
            self.began_s = time.perf_counter()
        elif isinstance(event, StepEnded) and event.recording:
            self.ended_s = time.perf_counter()


def tester() -> FastTester:
    """Return a device that swings at 10 Hz, with its samples already made."""
    settings = {"paced": False, "sensors": {"rate": "1000 kHz"}, "frequency_rate": "1000 Hz/s"}
    context = DeviceContext("tester", WallClock(), Path())
    device = FastTester(FastTesterSettings.model_validate(settings), context)
    device.connect(1.0)
    device.set("frequency", 10.0)
    device.second()
    return device


def recorded(folder: Path, device: FastTester, seconds: float) -> float:
    """Record some seconds of samples flat out; return the time, without the folding of the file."""
    timer, clock = Timer(), WallClock()
    step = replace(record("flat", seconds), channels=CHANNELS, units=UNITS)
    with RunWriter(folder, header_of(folder.name)) as writer:
        rig = Rig({"tester": device}, clock)
        rig.connect()
        rig.set("tester", "frequency", 10.0)
        bus = Bus([writer], [timer])
        answers, stop = UnattendedAnswers(), threading.Event()
        summary = run_plan(plan_of((), (step,), ()), rig, bus, clock, answers, stop, folder.name)
        rig.close()
    if summary.error is not None:
        raise summary.error
    return timer.ended_s - timer.began_s


def blocks(second: Mapping[str, np.ndarray], samples: int) -> Iterator[list[np.ndarray]]:
    for first in range(0, samples, BLOCK):
        start = first % round(RATE_HZ)
        yield [second[name][start : start + BLOCK] for name in CHANNELS]


def write_plainly(path: Path, second: Mapping[str, np.ndarray], seconds: float) -> float:
    """Write length, CRC-32 and samples of each block to a file; return the time."""
    began_s = synced_s = time.perf_counter()
    with path.open("xb", buffering=0) as file:
        for block in blocks(second, round(seconds * RATE_HZ)):
            checksum = 0
            for values in block:
                checksum = zlib.crc32(values, checksum)
            file.write(struct.pack("<II", 8 * BLOCK * len(block), checksum))
            for values in block:
                file.write(values)
            if time.perf_counter() - synced_s > 1.0:
                os.fsync(file.fileno())
                synced_s = time.perf_counter()
        os.fsync(file.fileno())
    return time.perf_counter() - began_s


def flat_out(folder: Path, seconds: float, times: int) -> list[Figure]:
    turns, size = [], seconds * RATE_HZ * BYTES / MB
    device, second = tester(), tester().second()
    for turn in range(-1, times):  # the first turn warms caches
        plain_s = write_plainly(folder / f"plain{turn}", second, seconds)
        turns.append((recorded(folder / f"run{turn}", device, seconds), plain_s))
        (folder / f"plain{turn}").unlink()
    pair = pair_of(turns[1:])
    note = "the check that every sample is finite, and the handing over between two threads"
    return [
        Figure("plain writer, blocks with CRC-32", pair.floor.rate(size), "MB/s", "floor"),
        Figure(
            "engine and journal, flat out",
            pair.ours.rate(size),
            "MB/s",
            ratio=pair.speed,
            target=at_least(0.6),
            note=note,
        ),
    ]


def filters(path: Path, times: int) -> list[Figure]:
    second, size, figures = tester().second(), RATE_HZ * BYTES / MB, []
    for name, options in (FILTERS | plugin_filters()).items():
        spread = repeated(partial(write_filtered, path, second, options), times)
        note = f"{size * MB / path.stat().st_size:.1f} times smaller"
        role = {"none": "floor", OURS: "ours"}.get(name, "other")
        figures.append(Figure(f"HDF5, {name}", spread.rate(size), "MB/s", role, note=note))
    return figures


def plugin_filters() -> Mapping[str, Mapping[str, object]]:
    """Return the filters that readers need a plugin for, if it is installed."""
    try:
        import hdf5plugin  # noqa: PLC0415  (optional)
    except ImportError:
        return {}
    return {"bitshuffle-lz4 (a plugin)": dict(hdf5plugin.Bitshuffle())}


def write_filtered(
    path: Path, second: Mapping[str, np.ndarray], options: Mapping[str, object]
) -> None:
    chunks = {"chunks": (16_384,)} if options else {}
    with h5py.File(path, "w", libver=("earliest", "v110")) as file:
        for name in CHANNELS:
            file.create_dataset(name, data=second[name], **chunks, **options)


def work() -> list[Work]:
    with tempfile.TemporaryDirectory() as name:
        once, twice, called = (Path(name) / part for part in ("once", "twice", "called"))
        device, second = tester(), RATE_HZ * BYTES
        short = allocated_peak(lambda: recorded(once, device, 1.0))
        long = allocated_peak(lambda: recorded(twice, device, 2.0))
        count = calls(lambda: recorded(called, device, 1.0))
        (part,) = (twice / "recordings").glob("*.h5")
        size, stored = part.stat().st_size, read(twice).recordings[0].samples
        return [
            Work("samples lost of 2 million", abs(2 * RATE_HZ - stored), 0),
            Work("blocks in memory at once", long / (BLOCK * BYTES), 6),
            Work("growth of memory by twice the length", long / short, 1.1),
            Work("calls of functions for ten blocks and a run", count, 12_000),
            Work("bytes of the file for a byte of samples", size / (2 * second), 0.3),
        ]
