"""The time of a set-point beside that of its devices: set, read, check a limit, store.

Microseconds for each of 2,000 points on a press that only remembers its set-point: a procedure in
YAML, planned, through engine, rig, bus and journal, with `run.log` as in every run; from the start
of the first point to the end of the last. Between two points the run can be stopped or paused, and
interlocks are read. The floor does the same to the same press and writes a line of csv, flushed: it
survives kill -9, as ours does.

A scan is one step: its start is recorded before the drive is touched, and each point before the
next one begins. In a sweep a point has its own steps, here two, of any kind: each is recorded
before it begins and after it has ended.

Synced: each value is on the disk before the next point (`durability: {sync: each_measurement}`);
its floor writes a line of JSON and waits for the disk. Through a thread: the press declares that it
may block, so each call of it goes to a worker and has a time limit. Plan and seal: the work before
and after a sweep.

The peers differ in what survives kill -9: PyMeasure's thread, Bluesky's lines and QCoDeS where each
point is flushed keep all finished points; QCoDeS by itself writes every few seconds (killed after
1,500 points it had none), and OpenHTF at the end. PyMeasure sets, reads, compares and writes a row,
and has neither a read-back of the drive nor limits for it, interlocks, pauses, times of its rows or
checksums.
"""

from __future__ import annotations

import csv
import io
import json
import os
import sys
import tempfile
import threading
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Self

from benchmarks.frame import (
    Figure,
    Scale,
    Spread,
    Work,
    allocated_peak,
    at_most,
    pair_of,
    peer,
    seconds,
)
from benchmarks.helpers_setpoints import LIMIT_NM, lab_of, loads_n
from rigrunner.api.events import StepStarted
from rigrunner.bus import Bus
from rigrunner.clock import WallClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import header_of, open_log, rig_of, syncs_measurements
from rigrunner.runfile import RunWriter
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.loose import read_journal

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from benchmarks.frame import Pair, Target
    from rigrunner.run.prepare import Planned

MICRO = 1e6
CSV_FACTOR = 20
"""Lines of csv per point, so that a turn of the floor takes as long as one of ours, and other load
of the machine affects both alike."""
LIMIT = "59 calls: an event is made, encoded, summed and written; set, read back, read, compared"
SWEEP_LIMIT = "250 calls: four events are made, encoded, summed and written (decision 16)"
PEER_LIMIT = "a read-back, limits of the drive, a date and time, a checksum, and who listens"
PEERS = {
    "pymeasure": "PyMeasure: worker, csv",
    "openhtf_dimensioned": "OpenHTF: a dimensioned measurement",
    "openhtf_phases": "OpenHTF: a phase a point",
    "qcodes": "QCoDeS: data set",
    "qcodes_flushed": "QCoDeS: data set, each point flushed",
    "robot": "Robot Framework: three keywords a point",
    "bluesky": "Bluesky: run engine, documents as lines",
}


def measure(scale: Scale) -> list[Figure]:
    points, times = scale.of(2000, 200), scale.of(15, 3)
    few = max(points // 10, 20)
    scan = flushed(points, times)
    durable, sweep = synced(few, times), flushed(points, times, sweep=True)
    slow, worked = synced(few, times, sweep=True), flushed(points, times, blocking=True)
    bare, disk = scan.floor.per(1 / MICRO), durable.floor.per(1 / MICRO)
    disk_note = f"the disk: {durable.ratio.median:.2f} x a synced line of JSON"
    thread_note = f"{worked.ratio.median / scan.ratio.median:.1f} x inline: two changes of threads"
    return [
        Figure("csv, a line flushed", bare, "us", "floor"),
        ours("a scan, kept from kill -9", scan, at_most(7), LIMIT),
        Figure("JSON, a line synced", disk, "us", "floor", disk.per(bare.median)),
        on_disk("a scan, kept from a power cut", durable, bare, at_most(35), disk_note),
        ours("a scan through a thread, kept from kill -9", worked, None, thread_note),
        ours("a sweep of steps, kept from kill -9", sweep, at_most(25), SWEEP_LIMIT),
        on_disk("a sweep of steps, kept from a power cut", slow, bare, None, "as above"),
        *around(points, times),
        *(peer_figure(scale, way, what, points, bare) for way, what in PEERS.items()),
        against("pymeasure", "a scan, in turn with PyMeasure and to it", scale, points),
    ]


def flushed(points: int, times: int, **lab: object) -> Pair:
    with Bench(points, **lab) as bench:
        return turns(bench, csv_lines, CSV_FACTOR, times)


def synced(points: int, times: int, **lab: object) -> Pair:
    with Bench(points, sync="each_measurement", **lab) as bench:
        return turns(bench, json_lines_synced, 1, times)


def on_disk(what: str, pair: Pair, bare: Spread, target: Target | None, note: str) -> Figure:
    """Return a figure with the ratio to a line that is flushed but not synced."""
    value = pair.ours.per(1 / MICRO)
    return Figure(what, value, "us", ratio=value.per(bare.median), target=target, note=note)


def against(way: str, what: str, scale: Scale, points: int) -> Figure:
    """Return a figure with the ratio to a peer, measured in turn with ours."""
    values, ratios = [], []
    with Bench(points) as bench:
        bench.run()
        for _ in range(scale.of(9, 2)):
            peer_result = peer_figure(scale, way, what, points)
            if peer_result.value is None:
                return Figure(what, None, "us", note=peer_result.note)
            values += (own_us := [MICRO * bench.run() / points for _ in range(scale.of(9, 2))])
            ratios.append(Spread.of(own_us).median / peer_result.value.median)
    ratio = Spread.of(ratios)
    return Figure(what, Spread.of(values), "us", ratio=ratio, target=at_most(1.5), note=PEER_LIMIT)


def ours(what: str, pair: Pair, target: Target | None, note: str) -> Figure:
    value = pair.ours.per(1 / MICRO)
    return Figure(what, value, "us", ratio=pair.ratio, target=target, note=note)


def around(points: int, times: int) -> list[Figure]:
    """Measure the time of a run before its first point and after its last."""
    plan_s, seal_s = [], []
    for _ in range(times):
        with Bench(points, sweep=True) as bench:
            plan_s.append(bench.planned_s)
            bench.go()
            seal_s.append(seconds(bench.writer.seal))
    by_point = points / MICRO
    return [
        Figure("plan of a sweep, before the run", Spread.of(plan_s).per(by_point), "us"),
        Figure("seal of a sweep, after the run", Spread.of(seal_s).per(by_point), "us"),
    ]


def peer_figure(
    scale: Scale, way: str, what: str, points: int, floor: Spread | None = None
) -> Figure:
    with tempfile.TemporaryDirectory() as folder:
        arguments = (way, points, scale.of(5, 2), folder)
        return peer(scale, what, "setpoints", *arguments, unit="us", floor=floor)


def turns(bench: Bench, floor: Callable[[int], float], factor: int, times: int) -> Pair:
    """Measure seconds per point in turn; the floor does `factor` times the points."""
    points, lines = bench.points, factor * bench.points
    bench.run(), floor(lines)
    return pair_of((bench.run() / points, floor(lines) / lines) for _ in range(times))


class Bench:
    """Points that are planned once, and run into a new folder each time."""

    def __init__(self, points: int, **station: object) -> None:
        self._temporary = tempfile.TemporaryDirectory()
        self._folder = Path(self._temporary.name)
        self._runs = 0
        self.points = points
        procedure, station_file = lab_of(self._folder / "lab", points, **station)
        registry = load_registry()
        began_s = time.perf_counter()
        self._planned: Planned = plan_run(procedure, station_file, registry, WallClock())
        self._header = header_of(self._planned, "run", {})
        self.planned_s = time.perf_counter() - began_s
        self.writer: RunWriter | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._temporary.cleanup()

    def run(self) -> float:
        """Return the seconds from the start of the first point to the end of the last."""
        self.go()
        events = read_journal(RunFolder(self.folder)).events
        first = next(event for event in events if isinstance(event, StepStarted))
        last = next(event for event in reversed(events) if getattr(event, "measurement", ""))
        return last.monotonic_s - first.monotonic_s

    def go(self) -> None:
        self._runs += 1
        planned, at_once = self._planned, syncs_measurements(self._planned)
        self.folder = folder = self._folder / f"run{self._runs}"
        with (
            rig_of(planned) as rig,
            RunWriter(folder, self._header, sync_measurements=at_once) as self.writer,
            open_log(folder) as log,
        ):
            bus = Bus(self.writer.sinks, log)
            unattended = UnattendedAnswers(), threading.Event(), folder.name
            summary = run_plan(planned.plan, rig, bus, planned.clock, *unattended)
        assert summary.outcome == "completed", summary.reason


class Press:
    """The press of the floors, like that of the bench."""

    def __init__(self) -> None:
        self._load_n = 0.0

    def set(self, load_n: float) -> None:
        self._load_n = load_n

    def read(self) -> float:
        return 1e-3 * self._load_n


def csv_lines(points: int) -> float:
    with lines() as file:
        press, write_row = Press(), csv.writer(file).writerow
        began = time.perf_counter()
        for load_n in loads_n(points):
            press.set(load_n)
            torque_nm = press.read()
            write_row((load_n, torque_nm, torque_nm <= LIMIT_NM))
            file.flush()
        return time.perf_counter() - began


def json_lines_synced(points: int) -> float:
    with lines() as file:
        press = Press()
        began = time.perf_counter()
        for load_n in loads_n(points):
            press.set(load_n)
            torque_nm = press.read()
            row = {"load": load_n, "torque": torque_nm, "ok": torque_nm <= LIMIT_NM}
            file.write(json.dumps(row) + "\n")
            file.flush()
            os.fsync(file.fileno())
        return time.perf_counter() - began


@contextmanager
def lines() -> Iterator[object]:
    with (
        tempfile.TemporaryDirectory() as folder,
        (Path(folder) / "lines").open("w", encoding="utf-8", newline="") as file,
    ):
        yield file


def work() -> list[Work]:
    """Count the work per further point: the difference between many and few points."""
    scan, threaded = each_point(), each_point(blocking=True)
    sweep, sweep_synced = each_point(sweep=True), each_point(sweep=True, sync="each_measurement")
    synced = each_point(sync="each_measurement")
    return [
        Work("calls of functions for a point of a scan", scan["calls"], 80),
        Work("calls for a point of a scan, through a thread", threaded["calls"], 340),
        Work("writes for a point of a scan", scan["write"], 1.1),
        Work("bytes of journal for a point of a scan, its plan among them", scan["bytes"], 280),
        Work("syncs for a point of a scan, each value at once", synced["fsync"], 1.1),
        Work("calls of functions for a point of a sweep", sweep["calls"], 340),
        Work("writes for a point of a sweep", sweep["write"], 6.5),
        Work("bytes of journal for a point of a sweep, its plan among them", sweep["bytes"], 3600),
        Work("syncs of the disk for a point of a sweep", sweep["fsync"], 0.1),
        Work("syncs for a point of a sweep, each value at once", sweep_synced["fsync"], 1.1),
        Work("bytes of memory to plan a point of a sweep", memory_to_plan(1000) / 1000, 5200),
    ]


def each_point(**station: object) -> dict[str, float]:
    few, many = count_work(100, **station), count_work(300, **station)
    return {what: (many[what] - few[what]) / 200 for what in many}


def count_work(points: int, **station: object) -> Counter[str]:
    """Count calls of functions, unbuffered writes and syncs in the thread of the run."""
    counts: Counter[str] = Counter()

    def count_call(_frame: object, event: str, what: object) -> None:
        if event in ("call", "c_call"):
            counts["calls"] += 1
        if event == "c_call" and (what is os.fsync or isinstance(what.__self__, io.FileIO)):
            # Tests replace os.fsync, so as not to wait for the disk.
            counts["fsync" if what is os.fsync else what.__name__] += 1

    with Bench(points, **station) as bench:
        bench.go()
        before = sys.getprofile()
        sys.setprofile(count_call)
        try:
            bench.go()
        finally:
            sys.setprofile(before)
        counts["bytes"] = (bench.folder / "journal" / "events.journal").stat().st_size
    return counts


def memory_to_plan(points: int) -> int:
    with tempfile.TemporaryDirectory() as folder:
        files = lab_of(Path(folder) / "lab", points, sweep=True)
        return allocated_peak(lambda: plan_run(*files, load_registry(), WallClock()))
