"""Lists the functions that a set-point, a block of samples and a verdict call.

    python tests/benchmarks/paths.py            # a table, and below it each file with its functions

Functions that are called once more for each further point or block are on its path; functions
called by `decide` are on that of a verdict. Only functions and methods of the package `rigrunner`
count, of the sources beside this file; or with PYTHONPATH, of other sources: `runner`, `plugins`,
`reports` and `tests` of another commit.
"""

from __future__ import annotations

import sys
import tempfile
import threading
from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

sys.path.append(str(Path(__file__).resolve().parent.parent))  # after PYTHONPATH

import numpy as np

import rigrunner
from benchmarks import helpers_setpoints
from benchmarks.setpoints import Bench
from rigrunner.bus import Bus
from rigrunner.clock import SimulatedClock
from rigrunner.engine import UnattendedAnswers, run_plan
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_station
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import header_of, rig_of
from rigrunner.runfile import RunWriter
from unit.analysis.helpers_analysis import acceptance, analysed, recording, run_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import CodeType, FrameType

FREQUENCIES = (1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0)
SOURCE = Path(rigrunner.__file__).parent
VERSION = helpers_setpoints._PROCEDURE.splitlines()[0]
RECORD = f"""\
{VERSION}
id: BLOCKS
revision: "A"
title: One recording
measurand: {{symbol: T, name: torque of a swing, unit: N·m}}
uses: {{tester: swing_tester}}
main:
  - set: {{tester.frequency: 5 Hz}}
  - record: {{channels: [tester.angle, tester.torque], duration: SECONDS s}}
teardown:
  - set: {{tester.frequency: 0 Hz}}
"""
Calls = Counter["CodeType"]


def main() -> None:
    paths = {
        "a point of a sweep: set, read, compared, kept": path_of_a_point(sweep=True),
        "a point of a scan: the same": path_of_a_point(),
        "a block of samples: checked, kept": path_of_a_block(),
        "a verdict: limits, rule, risks": path_of_a_verdict(),
    }
    sys.stdout.write("| path | files | functions |\n|---|---|---|\n")
    for name, codes in paths.items():
        sys.stdout.write(f"| {name} | {len(by_file(codes))} | {len(codes)} |\n")
    for name, codes in paths.items():
        sys.stdout.write(f"\n{name}\n")
        for file, functions in by_file(codes).items():
            sys.stdout.write(f"    {file}: {', '.join(functions)}\n")


def by_file(codes: set[CodeType]) -> dict[str, list[str]]:
    files: dict[str, list[str]] = {}
    for code in sorted(codes, key=lambda code: (code.co_filename, code.co_firstlineno)):
        file = str(Path(code.co_filename).relative_to(SOURCE))
        files.setdefault(file, []).append(code.co_qualname)
    return files


def path_of_a_point(**station: object) -> set[CodeType]:
    few, many = count_points(100, **station), count_points(300, **station)
    return {code for code in many if many[code] - few[code] >= 200}


def count_points(points: int, **station: object) -> Calls:
    with Bench(points, **station) as bench:
        bench.go()
        with counting() as calls:
            bench.go()
    return calls


def path_of_a_block() -> set[CodeType]:
    short, long = count_recording(10), count_recording(40)
    (blocks,) = {long[code] - short[code] for code in long if code.co_name == "block_bytes"}
    return {code for code in long if long[code] - short[code] >= blocks}


def count_recording(seconds: int) -> Calls:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        procedure = folder / "procedure.yaml"
        procedure.write_text(RECORD.replace("SECONDS", str(seconds)), encoding="utf-8")
        planned = plan_run(procedure, find_station("simulated"), load_registry(), SimulatedClock())
        writer = RunWriter(folder / "run", header_of(planned, "run", {}))
        with rig_of(planned) as rig, writer, counting() as calls:
            unattended = UnattendedAnswers(), threading.Event(), "run"
            run_plan(planned.plan, rig, Bus(writer.sinks), planned.clock, *unattended)
    return calls


def path_of_a_verdict() -> set[CodeType]:
    loaded, no_load = (
        run_of(*(recording(np.full(30, mean) + 1e-3 * hz, hz, load_n=load_n) for hz in FREQUENCIES))
        for mean, load_n in ((1.6, 1000.0), (0.9, 0.0))
    )
    with counting(within="decide") as calls:
        analysed(loaded, no_load, accept=acceptance())
    return set(calls)


@contextmanager
def counting(within: str = "") -> Iterator[Calls]:
    """Count calls of our functions in this thread, optionally only `within` one of the analysis."""
    calls: Calls = Counter()
    depth = 0

    def count_call(frame: FrameType, event: str, _: object) -> None:
        nonlocal depth
        code = frame.f_code
        if event not in ("call", "return") or not code.co_filename.startswith(str(SOURCE)):
            return
        if code.co_name == within and "analysis" in code.co_filename:
            depth += 1 if event == "call" else -1
        if event == "call" and (depth or not within) and "<" not in code.co_name:
            calls[code] += 1

    sys.setprofile(count_call)
    try:
        yield calls
    finally:
        sys.setprofile(None)


if __name__ == "__main__":
    main()
