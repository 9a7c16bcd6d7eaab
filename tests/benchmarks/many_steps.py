"""A run of many steps: time, bytes and memory per step, from the plan to the report.

A sweep of a press that only remembers its set-point; half of its steps set it, and half read with a
limit, as in `setpoints`. The whole run is a separate process: it is planned, done, analysed, sealed
and reported; imports are not counted. The floor writes a line of csv for each step and flushes it.
Memory is the peak resident memory of the process (VmHWM of Linux, which starts anew with each
program; `ru_maxrss` includes that of the parent), less that after its imports. Time is processor
time.

A plan has 100,000 actions at most, so that 99,980 steps stand for 10^5, and 10^6 are refused.
"""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.frame import Figure, Scale, Spread, Work, allocated_peak, at_most
from benchmarks.helpers_setpoints import lab_of
from rigrunner.cli.main import raise_gc_threshold
from rigrunner.clock import WallClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute

if TYPE_CHECKING:
    from rigrunner.run.finish import FinishedRun

MICRO, KILO = 1e6, 1e3
TIME = "sealing takes three tenths: events as JSON, packed; the run a quarter, the plan a quarter"
MEMORY = "the steps of the plan and the rows of the result are held"
MAX_STEPS = 10_000
"""Steps of one pass; more steps take several passes."""


def measure(scale: Scale) -> list[Figure]:
    few, many = scale.of(10_000, 200), scale.of(99_980, 400)
    lines_s: list[float] = []
    figures: list[Figure] = []
    memory = {}
    for steps in (few, many):
        turns = []
        for _ in range(scale.of(3, 1)):
            lines_s.append(csv_line_s(scale.of(200_000, 2000)))
            turns.append((lines_s[-1], run_in_process(steps)))
        each_s = [measured["processor_s"] / steps for _, measured in turns]
        to_line = [step_s / line for step_s, (line, _) in zip(each_s, turns, strict=True)]
        memory[steps] = Spread.of([measured["memory_kb"] / KILO for _, measured in turns])
        bytes_each = Spread.of([measured["bytes"] / steps for _, measured in turns])
        figures += [
            Figure(f"whole run of {steps:,} steps, a step",
                   Spread.of([step_s * MICRO for step_s in each_s]), "us",
                   ratio=Spread.of(to_line), target=at_most(40), note=TIME),
            Figure(f"run.h5 of {steps:,} steps, a step", bytes_each, "B",
                   target=at_most(300, "B")),
            Figure(f"memory of {steps:,} steps", memory[steps], "MB", note=MEMORY),
        ]  # fmt: skip
    grown = (memory[many].median - memory[few].median) * KILO / (many - few)
    floor = Spread.of([line_s * MICRO for line_s in lines_s])
    return [
        Figure("csv, a line flushed", floor, "us", "floor"),
        *figures,
        Figure("memory for each further step", Spread.of([grown]), "kB", note=MEMORY),
    ]


def csv_line_s(lines: int) -> float:
    """Return the processor time of a flushed line of csv."""
    with (
        tempfile.TemporaryDirectory() as folder,
        (Path(folder) / "lines").open("w", encoding="utf-8", newline="") as file,
    ):
        write_row, began_s = csv.writer(file).writerow, time.process_time()
        for number in range(lines):
            write_row((1e-3 * number, 1e-6 * number, True))
            file.flush()
        return (time.process_time() - began_s) / lines


def run_in_process(steps: int) -> dict[str, float]:
    """Measure a run of this number of steps in a separate process."""
    command = [sys.executable, "-m", "benchmarks.many_steps", str(steps)]
    tests = Path(__file__).resolve().parents[1]
    process = subprocess.run(command, cwd=tests, capture_output=True, text=True, check=True)
    measured: dict[str, float] = json.loads(process.stdout.splitlines()[-1])
    return measured


def whole_run(folder: Path, steps: int) -> FinishedRun:
    """Plan, do, analyse, seal and report a run of this number of steps."""
    times = -(-steps // MAX_STEPS)
    files = lab_of(folder / "lab", steps // times // 2, sweep=True, times=times)
    finished = execute(
        plan_run(*files, load_registry(), WallClock()),
        runs=folder / "runs",
        inputs={},
        partners={},
        answers=UnattendedAnswers(),
        stop=threading.Event(),
    )
    assert finished.error is None, finished.error
    return finished


def peak_kb() -> int:
    """Return the peak resident memory of this process in kB."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1])


def bytes_of(finished: FinishedRun) -> int:
    return (finished.folder / "run.h5").stat().st_size


def work() -> list[Work]:
    """Count the work per further step: the difference between many and few steps."""
    count_work(100)  # allocates modules and caches
    few, many = count_work(1000), count_work(3000)
    return [
        Work("bytes of run.h5 for a step", (many[0] - few[0]) / 2000, 350),
        Work("bytes of memory for a step", (many[1] - few[1]) / 2000, 2_500),
    ]


def count_work(steps: int) -> tuple[int, int]:
    """Return the size of the file of a run, and its peak memory, in bytes."""
    finished: list[FinishedRun] = []
    with tempfile.TemporaryDirectory() as folder:
        peak = allocated_peak(lambda: finished.append(whole_run(Path(folder), steps)))
        return bytes_of(finished[0]), peak


def main() -> None:
    raise_gc_threshold()  # as the command does
    load_registry()
    with tempfile.TemporaryDirectory() as folder:
        before_kb, began_s = peak_kb(), time.process_time()
        finished = whole_run(Path(folder), int(sys.argv[1]))
        measured = {
            "processor_s": time.process_time() - began_s,
            "memory_kb": peak_kb() - before_kb,
            "bytes": bytes_of(finished),
        }
    sys.stdout.write(f"{json.dumps(measured)}\n")


if __name__ == "__main__":
    main()
