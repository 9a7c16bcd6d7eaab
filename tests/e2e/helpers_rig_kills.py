"""Kills the processes that control an energised rig, repeatedly, and checks rig and samples.

Run as a program, in tests/: `python -m e2e.helpers_rig_kills FOLDER KILLS SEED`. The rig is a file
that outlives every process (`helpers_supply`). Killed by SIGKILL at a random instant are, in turn:
the process of a run, the run and its guardian, a run's process under the panel, the panel's server,
and both of these. After each kill two conditions must hold: no row is lost that a listener
received; and the rig is safe, or the next start reports it before it asks anything. After that
start it is safe, and no marker is left. Prints one JSON line per kill and a table of all; ends with
a traceback at the first kill after which a condition does not hold.
"""

from __future__ import annotations

import io
import json
import os
import random
import signal
import sys
import time
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path

import psutil

from e2e.helpers_panel import Screen, ready, rig_process, served
from e2e.helpers_supply import GUARDED, SupplyLab
from rigrunner.api.errors import DataError
from rigrunner.cli.main import main
from rigrunner.rig_state import is_held, read_marker, shared_folder
from rigrunner.run.locate import run_names
from rigrunner.runfile import read

ROUND = ("run", "guardian", "run", "guardian", "panel", "run", "guardian", "server", "both", "run")
"""The targets in turn: under the panel each kill takes several times as long."""
WORDS = {
    "run": "the process of a run",
    "guardian": "the run and its guardian",
    "panel": "a run's process under the panel",
    "server": "the panel's server",
    "both": "the server and the run's process",
}
NOTES = """\
import os

from rigrunner.api.events import StepEnded
from rigrunner.api.hooks import EventSinkRecord, hookimpl
from rigrunner.api.settings import Settings

api_version = 1


class NoteSettings(Settings):
    file: str


def noter(settings):
    opened = os.open(settings.file, os.O_WRONLY | os.O_CREAT | os.O_APPEND)

    def note(event):
        if isinstance(event, StepEnded) and event.ok and event.measurement:
            os.write(opened, f"{event.values['psu.voltage']}\\n".encode())

    return note


@hookimpl
def rigrunner_event_sinks():
    help_text = "notes each row where a kill cannot take it back"
    return [
        EventSinkRecord(name="row_notes", help=help_text, settings=NoteSettings, factory=noter)
    ]
"""
SHORT = (
    ("  - set: {psu.speed: 20 Hz}\n", ""),
    ("times: 12", "times: 1"),
    ("0.05 s", "0.01 s"),
)
"""The differences of the procedure of the next start from the killed one."""
SPECIMEN = "Put the specimen between the terminals"
PATIENCE_S = 90.0


class Bench:
    """The lab whose runs are killed, and the duration of an undisturbed run."""

    def __init__(self, folder: Path) -> None:
        os.environ["RIGRUNNER_LOCKS"] = str(folder / "rigs")
        self.lab = SupplyLab(folder / "lab")
        self.lab.add_station("station.yaml", self.lab.station_id, GUARDED)
        self.notes = folder / "notes"
        (self.lab.folder / "plugins" / "row_notes.py").write_text(NOTES, encoding="utf-8")
        listeners = f"listeners:\n  - {{plugin: row_notes, settings: {{file: {self.notes}}}}}\n"
        with self.lab.station.open("a", encoding="utf-8") as station:
            station.write(listeners)
        text = self.lab.procedure.read_text(encoding="utf-8")
        for old, new in SHORT:
            assert old in text
            text = text.replace(old, new)
        self.short = self.lab.folder / "short.yaml"
        self.short.write_text(text, encoding="utf-8")
        self.lock = shared_folder() / f"{self.lab.station_id}.lock"
        self.warm_up(folder / "warm")
        began_s = time.monotonic()
        child = self.start(folder / "whole", self.lab.procedure)
        until(lambda: self.lab.outputs() != (0.0, 0.0))
        energised_s = time.monotonic()
        until(lambda: self.lab.outputs() == (0.0, 0.0))
        self.energised_s = time.monotonic() - energised_s
        assert os.waitpid(child, 0)[1] == 0, output_of(folder / "whole")
        self.life_s = time.monotonic() - began_s

    def warm_up(self, runs: Path) -> None:
        """Do a whole run in this process, so that forked ones need not import anything."""
        command = ["run", self.short, "--station", self.lab.station, "--runs", runs, "--unattended"]
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()) as stderr:
            assert main([str(argument) for argument in command]) == 0, stderr.getvalue()

    def start(self, runs: Path, procedure: Path, *more: str) -> int:
        """Start a run in a process of its own, which answers yes, and return its process id.

        Its output is in `output_of`.
        """
        command = ["run", procedure, "--station", self.lab.station, "--runs", runs, *more]
        return run_in_fork(command, runs)

    def kill(self, kind: str, runs: Path, chance: random.Random) -> None:
        """Start a run, and kill the processes of the kind at a random instant of its life."""
        if kind in ("run", "guardian"):
            child = self.start(runs, self.lab.procedure)
            self.wait(chance, lambda: has_ended(child))
            victims = [child]
            with suppress(psutil.NoSuchProcess):
                children = psutil.Process(child).children(recursive=True)
                victims += [process.pid for process in children]
            kill_all(victims if kind == "guardian" else [child], chance)
            os.waitpid(child, 0)
            return
        with served(self.lab.folder, runs) as server:
            screen = Screen(server, "c" * 16)
            pair = ready(screen, "procedure.yaml")
            screen.post("run/start", 202, **pair)
            screen.answer()
            with suppress(StopIteration):  # the run is over
                run = rig_process(server)
                self.wait(chance, lambda: is_zombie(run))
                victims_by_kind = {"panel": [run], "server": [server.process.pid]}
                kill_all(victims_by_kind.get(kind, [run, server.process.pid]), chance)
                until(lambda: not psutil.pid_exists(run) or is_zombie(run))
            screen.close()

    def wait(self, chance: random.Random, is_over) -> None:
        """Wait for a random instant: in four of five cases after the first set-point."""
        if chance.random() < 1 / 5:
            time.sleep(chance.uniform(0.0, self.life_s))
            return
        later_s = chance.uniform(0.0, self.energised_s)
        while self.lab.outputs() == (0.0, 0.0) and not is_over():
            time.sleep(0.001)
        time.sleep(later_s)

    def check(self, kind: str, runs: Path) -> dict[str, object]:
        """Check the state after a kill, start the next run, and return what was found."""
        until(lambda: not is_held(self.lock))  # a guardian, and a run that ends itself, need a time
        notes = list(map(float, self.notes.read_text().split())) if self.notes.exists() else []
        rows = [value for name in run_names(runs) for value in rows_of(runs / name)]
        assert rows[: len(notes)] == notes, f"{notes} were told, {rows} are kept"
        drives, marker = self.lab.outputs(), read_marker(self.lab.station_id)
        is_safe = drives == (0.0, 0.0)
        assert is_safe or marker is not None, f"the rig is at {drives}, and no marker says so"
        child = self.start(runs, self.short)
        code, output = os.waitpid(child, 0)[1], output_of(runs)
        assert code == 0, output
        assert self.lab.outputs() == (0.0, 0.0)
        assert read_marker(self.lab.station_id) is None
        if marker is not None:
            assert -1 < output.find("left energised by STEPS") < output.index(SPECIMEN), output
            events = read(runs / run_names(runs)[-1]).events
            assert any(getattr(event, "action", "") == "found energised" for event in events)
        conclusion = "told before any question"
        if is_safe:
            conclusion = (
                "the guardian made it safe"
                if marker is not None
                else "not energised, or made safe by its process"
            )
        counts = {"rows": len(rows), "noted": len(notes)}
        return {"kind": kind, "how": conclusion, **counts, "stood": drives}


def run_in_fork(command: list[object], runs: Path) -> int:
    """Call the command line in a child process of the same session."""
    runs.mkdir(exist_ok=True)
    child = os.fork()
    if child:
        return child
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(os.open(runs.with_suffix(".stderr"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        reading, writing = os.pipe()
        os.write(writing, b"yes\n" * 8)
        os.close(writing)
        os.dup2(reading, 0)
        sys.stdin = os.fdopen(0)
        sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
        os._exit(main([str(argument) for argument in command]))
    finally:
        os._exit(70)


def output_of(runs: Path) -> str:
    return runs.with_suffix(".stderr").read_text(encoding="utf-8", errors="replace")


def kill_all(processes: list[int], chance: random.Random) -> None:
    """Kill processes in random order, as quickly as possible."""
    chance.shuffle(processes)
    for process in processes:
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)


def has_ended(child: int) -> bool:
    """Return whether a child has ended; it can still be waited for."""
    return os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def is_zombie(process: int) -> bool:
    try:
        return psutil.Process(process).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def until(condition) -> None:
    until_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < until_s, "it has not come to its end"
        time.sleep(0.05)


def rows_of(folder: Path) -> list[float]:
    try:
        return [measurement.values["psu.voltage"] for measurement in read(folder).measurements]
    except DataError:  # it was killed before its header was on the disk
        return []


def kills(folder: Path, number: int, seed: int):
    """Yield the state after each kill."""
    folder.mkdir(parents=True, exist_ok=True)
    chance, bench = random.Random(seed), Bench(folder)  # noqa: S311  (it is to be repeatable)
    for index in range(number):
        kind, runs = ROUND[index % len(ROUND)], folder / f"{index:03d}"
        bench.notes.unlink(missing_ok=True)
        bench.kill(kind, runs, chance)
        yield {"kill": index, **bench.check(kind, runs)}


def table(results: list[dict[str, object]]) -> str:
    """Return the numbers of kills by their outcome, as a table."""
    ways = sorted({str(kill["how"]) for kill in results})
    counted = Counter((kill["kind"], kill["how"]) for kill in results)
    lines = [f"| killed | kills | {' | '.join(ways)} | rows reported | rows lost |"]
    lines.append("|---|" + "---:|" * (len(ways) + 3))
    for kind, words in WORDS.items():
        of_kind = [kill for kill in results if kill["kind"] == kind]
        if of_kind:
            counts = " | ".join(str(counted[kind, way]) for way in ways)
            rows = sum(int(str(kill["noted"])) for kill in of_kind)
            lines.append(f"| {words} | {len(of_kind)} | {counts} | {rows:,} | 0 |")
    return "\n".join(lines)


if __name__ == "__main__":
    place, count, start = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    results = []
    for result in kills(place, count, start):
        results.append(result)
        print(json.dumps(result), flush=True)  # noqa: T201
    print(table(results))  # noqa: T201
