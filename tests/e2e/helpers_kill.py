"""Kills a process that records runs, repeatedly, and lists what had been reported as stored.

Run as a program, in tests/: `python -m e2e.helpers_kill FOLDER KILLS SEED`. It imports once and
forks a writer per kill. A writer records and seals one run after the other through the real engine,
and notes each recording in a file once the run file has taken its end. Prints one JSON line per
kill.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from pathlib import Path

import numpy as np

from helpers_devices import FakeTester, plan_of, record, run
from rigrunner.api.events import Event, StepEnded
from rigrunner.runfile import RunWriter
from unit.runfile.helpers_runfile import header_of

RECORDINGS = 4
SECONDS = 2.5
LIVES = 3.0
"""The longest life, in multiples of the measured time to record and seal a run."""


def name_of(number: int) -> str:
    return f"{number:03d}"


class Noter:
    """Logs each finished recording, and each sealed run, in a file that survives a kill."""

    def __init__(self, path: Path, run_id: str) -> None:
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self._run_id = run_id

    def note(self, what: str) -> None:
        os.write(self._descriptor, f"{self._run_id} {what}\n".encode())

    def __call__(self, event: Event) -> None:
        if isinstance(event, StepEnded) and event.ok and event.recording:
            self.note(event.recording)


def write_runs_until_killed(folder: Path) -> None:
    for number in range(1_000_000):
        run_id = f"run{number:04d}"
        noter = Noter(folder / "notes", run_id)
        main = [record(name_of(index), seconds=SECONDS) for index in range(RECORDINGS)]
        with RunWriter(folder / run_id, header_of(run_id)) as writer:
            run(FakeTester(), plan_of((), main, ()), critical=[writer], guarded=[noter])
            writer.seal({"number": number})
            noter.note("sealed")


def begin(folder: Path) -> int:
    writer = os.fork()
    if writer == 0:
        write_runs_until_killed(folder)
        os._exit(1)
    return writer


def time_of_a_run(folder: Path) -> float:
    """Return how long a writer takes until its first run is sealed."""
    folder.mkdir()
    notes, began, writer = folder / "notes", time.monotonic(), begin(folder)
    while not (notes.exists() and "sealed" in notes.read_text()):
        time.sleep(0.002)
    run_s = time.monotonic() - began
    os.kill(writer, signal.SIGKILL)
    os.waitpid(writer, 0)
    return run_s


def kill_one(folder: Path, life_s: float) -> None:
    writer = begin(folder)
    time.sleep(life_s)
    os.kill(writer, signal.SIGKILL)
    _, status = os.waitpid(writer, 0)
    if os.WTERMSIG(status) != signal.SIGKILL:
        raise SystemExit(f"the writer ended by itself: status {status}")


def main() -> None:
    folder, kills, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    random_life = random.Random(seed)  # noqa: S311  (instants of kills need no secrecy)
    np.zeros(1)
    longest_s = LIVES * time_of_a_run(folder / "first")
    for number in range(kills):
        kill_folder = folder / f"kill{number:04d}"
        kill_folder.mkdir()
        life_s = random_life.uniform(0.0, longest_s)
        kill_one(kill_folder, life_s)
        print(json.dumps({"folder": str(kill_folder), "life_s": life_s}), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
