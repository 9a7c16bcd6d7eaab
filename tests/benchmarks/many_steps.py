"""A run of many steps: time, bytes and memory of each, from the plan to the sealed file and report.

A sweep of a press that does nothing but remember, half of its steps a set-point and half a reading
with a limit, as `setpoints` has it. The whole run is a process of its own: it is planned, done,
analysed, sealed and reported; imports are not counted. The floor writes a line of csv for each step
and flushes it. Memory is the most that the process had resident (VmHWM of Linux, which begins again
with each program; `ru_maxrss` begins with that of the parent), less that after its imports. Time is
that of the processor.

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
from rigrunner.clock import WallClock
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute

if TYPE_CHECKING:
    from rigrunner.run.finish import FinishedRun

MICRO, KILO = 1e6, 1e3
TIME = "the record is written to the file as JSON, and read twice: for the analysis and the report"
MEMORY = "the steps of the plan and the rows of the result are held"
MOST = 10_000
"""Steps of one pass; of more there are several passes."""


def measure(scale: Scale) -> list[Figure]:
    few, many = scale.of(10_000, 200), scale.of(99_980, 400)
    lines_s: list[float] = []
    figures: list[Figure] = []
    memory = {}
    for steps in (few, many):
        turns = []
        for _ in range(scale.of(3, 1)):
            lines_s.append(csv_line_s(scale.of(200_000, 2000)))
            turns.append((lines_s[-1], in_process(steps)))
        each_s = [measured["processor_s"] / steps for _, measured in turns]
        to_line = [step_s / line for step_s, (line, _) in zip(each_s, turns, strict=True)]
        memory[steps] = Spread.of([measured["held_kb"] / KILO for _, measured in turns])
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
    """Return the processor time of a line of csv that is flushed."""
    with (
        tempfile.TemporaryDirectory() as folder,
        (Path(folder) / "lines").open("w", encoding="utf-8", newline="") as file,
    ):
        keep, began = csv.writer(file).writerow, time.process_time()
        for number in range(lines):
            keep((1e-3 * number, 1e-6 * number, True))
            file.flush()
        return (time.process_time() - began) / lines


def in_process(steps: int) -> dict[str, float]:
    """Return what a run of so many steps takes in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.many_steps", str(steps)]
    tests = Path(__file__).resolve().parents[1]
    process = subprocess.run(command, cwd=tests, capture_output=True, text=True, check=True)
    measured: dict[str, float] = json.loads(process.stdout.splitlines()[-1])
    return measured


def whole_run(folder: Path, steps: int) -> FinishedRun:
    """Plan, do, analyse, seal and report a run of so many steps."""
    times = -(-steps // MOST)
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


def held_kb() -> int:
    """Return the most that this process had resident, in kB."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1])


def bytes_of(finished: FinishedRun) -> int:
    return (finished.folder / "run.h5").stat().st_size


def work() -> list[Work]:
    """Count the work of one more step: of many, less what few take."""
    counted(100)  # what is allocated but once: modules, caches
    few, many = counted(1000), counted(3000)
    return [
        Work("bytes of run.h5 for a step", (many[0] - few[0]) / 2000, 350),
        Work("bytes of memory for a step", (many[1] - few[1]) / 2000, 2_500),
    ]


def counted(steps: int) -> tuple[int, int]:
    """Return the bytes of the file of a run of so many steps, and the most of its memory."""
    finished: list[FinishedRun] = []
    with tempfile.TemporaryDirectory() as folder:
        peak = allocated_peak(lambda: finished.append(whole_run(Path(folder), steps)))
        return bytes_of(finished[0]), peak


def main() -> None:
    load_registry()
    with tempfile.TemporaryDirectory() as folder:
        before_kb, began = held_kb(), time.process_time()
        finished = whole_run(Path(folder), int(sys.argv[1]))
        measured = {
            "processor_s": time.process_time() - began,
            "held_kb": held_kb() - before_kb,
            "bytes": bytes_of(finished),
        }
    sys.stdout.write(f"{json.dumps(measured)}\n")


if __name__ == "__main__":
    main()
