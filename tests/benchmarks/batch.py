"""Studies and re-analysis of many runs: the speed of two processes compared with one.

The floor does the same in one process, with one thread for linear algebra, as each of the two has.
Their start is included: a second of imports in each. Rigs of the study of coverage are recorded and
analysed in memory; stored runs of the demonstration are read from the disk, and their results
written. One and two processes alternate. Other programs take their share of the second core, so
that the figure is valid only on a quiet machine.
The scheduler itself is measured with items without work, compared with the pools of Python's
standard library, which do not survive the death of a process.
"""

from __future__ import annotations

import json
import resource
import shutil
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

from benchmarks.frame import Figure, Spread, Work, at_least, at_most, paired, repeated
from helpers_workflow import run
from rigrunner.clock import SimulatedClock
from rigrunner.jobs import InProcess, Processes, journal
from rigrunner.run.locate import find_procedure
from rigrunner_bearings.study.case_runner import CaseRunner
from rigrunner_bearings.study.coverage import run_coverage
from unit.jobs.helpers_jobs import Squares
from unit.rigrunner_fleet.reanalysis.helpers_reanalysis import reanalysed

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.frame import Scale

SPEED_UP = at_least(1.6)
"""Within 20 % of linear."""
NO_STOP = Event()
MICRO = 1e6
TURNS = 3


def measure(scale: Scale) -> list[Figure]:
    items = scale.of(2000, 20)
    figures = [*scheduler(items, scale.of(7, 1)), resuming(scale.of(100_000, 100))]
    return figures if scale.short else [*study(rigs=8), *reanalysis(copies=8), *figures]


def study(rigs: int) -> list[Figure]:
    def run_study(jobs: int) -> None:
        runner = CaseRunner(Processes(jobs), NO_STOP, lambda *_: None)
        run_coverage(rigs=rigs // 2, seed=1, runner=runner)

    return speed_up("study coverage", run_study, rigs, "rigs/min")


def reanalysis(copies: int) -> list[Figure]:
    with tempfile.TemporaryDirectory() as name:
        folder, clock = Path(name), SimulatedClock()
        for procedure in ("no_load_inertia_sweep", "starting_torque_1000n"):
            finished = run(find_procedure(procedure), folder / "runs", clock=clock)
        for number in range(copies):
            shutil.copytree(finished.folder, folder / "lab" / str(number))

        def reanalyse(jobs: int) -> None:
            with tempfile.TemporaryDirectory(dir=folder) as out:
                reanalysed(folder / "lab", Path(out), workers=Processes(jobs))

        return speed_up("reanalyse, demonstration", reanalyse, copies, "runs/min")


def speed_up(what: str, call: Callable[[int], None], count: int, unit: str) -> list[Figure]:
    pair = paired(partial(call, 2), partial(call, 1), TURNS)
    work = Spread.of(processor_s(partial(call, 2)) / processor_s(partial(call, 1)) for _ in "12")
    minutes = count * 60
    note = "the start of the processes; the memory that both share"
    return [
        Figure(f"{what}, 1 process", pair.floor.rate(minutes), unit, "floor"),
        Figure(
            f"{what}, 2 processes",
            pair.ours.rate(minutes),
            unit,
            ratio=pair.speed,
            target=SPEED_UP,
            note=note,
        ),
        Figure(
            f"{what}, processor time of 2 against 1",
            work,
            "x",
            target=at_most(1.25, "x"),
            note="what is left to gain by processes lies beyond this; hardly moved by other load",
        ),
    ]


def processor_s(call: Callable[[], None]) -> float:
    """Return the processor time of all child processes of a call."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    call()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def scheduler(items: int, times: int) -> list[Figure]:
    """Return the overhead per item, including the start of two processes."""
    numbers = list(range(-items, 0))
    ours = repeated(lambda: list(Processes(2).outcomes(abs, numbers, NO_STOP)), times)
    pool = repeated(partial(by_pool, numbers), times)
    executor = repeated(partial(by_executor, numbers), times)
    unit, count = "us/item", items / MICRO
    return [
        Figure(f"{items} empty items, 2 processes", ours.per(count), unit),
        Figure("multiprocessing.Pool.imap", pool.per(count), unit, "peer"),
        Figure("ProcessPoolExecutor.map", executor.per(count), unit, "peer"),
    ]


def by_pool(numbers: list[int]) -> None:
    with get_context("spawn").Pool(2) as pool:
        list(pool.imap(abs, numbers))


def by_executor(numbers: list[int]) -> None:
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        list(pool.map(abs, numbers))


def resuming(items: int) -> Figure:
    """Return the time to find that all runs are done already."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "done"
        with journal(path, {}) as results:
            for number in range(items):
                key = json.dumps([f"rig/run-{number}", "200000000 1"])
                results.add(key, {"torque_nm": 0.7} | ROW)

        def reopen() -> None:
            with journal(path, {}) as results:
                assert len(results) == items

        return Figure(f"going on after {items:,} items", repeated(reopen, 5), "s")


ROW = dict.fromkeys(("run", "run_id", "procedure", "station", "verdict", "started_utc"), "x" * 30)


def work() -> list[Work]:
    with tempfile.TemporaryDirectory() as name:
        task = Squares(Path(name))
        list(Processes(2).outcomes(task, list(range(50)), NO_STOP))
        attempts = task.attempts()
        marks = {mark.name.split("-")[1] for mark in Path(name).iterdir()}
    return [
        Work("times that an item is done", len(attempts) / 50, 1),
        Work("processes for 50 items by two", len(marks), 2),
        Work("bytes kept for a line of the summary", bytes_kept(), 1000),
    ]


def bytes_kept() -> float:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "done"
        with journal(path, {}) as results:
            before = path.stat().st_size
            for outcome in InProcess().outcomes(str, list(range(100)), NO_STOP):
                results.add(outcome.answer.value, ROW)
        return (path.stat().st_size - before) / 100
