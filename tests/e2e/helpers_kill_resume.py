"""Kills runs, their sealing and their resumption, repeatedly, and checks what is left.

Run as a program, in tests/: `python -m e2e.helpers_kill_resume FOLDER KILLS SEED`. It imports once
and forks a process per kill. Each run is killed at a random instant and resumed; most resumptions
are killed too; the last one is left to finish. After each kill, what is on the disk is checked
against a run that was never interrupted. Prints one JSON line per kill; ends with a traceback at
the first failed check.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from e2e.helpers_kill import Noter
from e2e.helpers_numbers import numbers
from e2e.helpers_resume import NO_LOAD, resume_run
from helpers_workflow import START, quick_procedure, station_file
from rigrunner.api.errors import DataError
from rigrunner.api.events import RunEnded, StepEnded, StepStarted
from rigrunner.clock import SimulatedClock
from rigrunner.documents.verifying.run import verify_run
from rigrunner.engine import UnattendedAnswers
from rigrunner.registry import load_registry
from rigrunner.run.inputs import answer_inputs
from rigrunner.run.prepare import plan_run
from rigrunner.run.record import execute
from rigrunner.run.report import write_report
from rigrunner.runfile import read

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.data import Recording
    from rigrunner.runfile import StoredRun

SHORT = (
    ("[8 Hz, 15 Hz, 20 Hz, 25 Hz, 35 Hz]", "[15 Hz, 20 Hz, 25 Hz, 35 Hz]"),
    ("cycles: 12}", "cycles: 10}"),
)
NO_DRIFT = ("{seed: 1}", "{seed: 1, sensors: {drift: 0 N·m}}")
"""So that a later zero is the same, and a resumed run has the same numbers."""
PLACES = (
    "before its folder",
    "before its header",
    "in setup",
    "between recordings",
    "in a recording",
    "in teardown",
    "run over, not sealed",
    "sealed, no report yet",
    "sealed, with report",
)
WORST_CASE = 4
"""The most kills of one run."""
GIVES_UP = 0.3
"""The share of kills after which a run is left to finish."""


class Laboratory:
    """The files of a run, the uninterrupted run, and its duration."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.registry = load_registry()
        self.procedure = quick_procedure(folder, NO_LOAD, *SHORT)
        self.station = station_file(folder, NO_DRIFT)
        self.begin(folder / "warm")
        started = time.time()
        self.begin(folder / "undisturbed")
        run = run_in(folder / "undisturbed")
        self.life_s = time.time() - started
        self.sealed_s = (run / "run.h5").stat().st_mtime - started
        self.undisturbed = read(run)
        self.document = json.loads((run / "result.json").read_text(encoding="utf-8"))

    def instant_s(self, chance: random.Random) -> float:
        """Return when to kill: in two of three cases before the run is sealed."""
        return chance.uniform(0.0, self.sealed_s if chance.random() < 2 / 3 else self.life_s)

    def begin(self, place: Path) -> None:
        """Do a run from its first step to its report."""
        place.mkdir(exist_ok=True)
        answers = UnattendedAnswers()
        planned = plan_run(self.procedure, self.station, self.registry, SimulatedClock(START))
        execute(
            planned,
            runs=place,
            inputs=answer_inputs(planned.procedure, {}, answers),
            partners={},
            answers=answers,
            stop=_Never(),
            listeners=[Noter(place / "notes", "run")],
        )

    def resume(self, place: Path) -> None:
        """Resume the run, to its report."""
        resume_run(run_in(place), listeners=[Noter(place / "notes", "run")])


class _Never:
    def is_set(self) -> bool:
        return False


def run_in(place: Path) -> Path:
    (run,) = place.glob("*_*")
    return run


def is_killed(work: Callable[[], None], life_s: float | None) -> bool:
    """Do some work in a child process; return whether SIGKILL ended it before it was done."""
    child = os.fork()
    if child == 0:
        try:
            work()
        except BaseException as error:  # noqa: BLE001  (the parent must know)
            print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)  # noqa: T201
            os._exit(1)
        os._exit(0)
    if life_s is not None:
        time.sleep(life_s)
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return True
    assert os.WEXITSTATUS(status) == 0, "the run failed by itself"
    return False


def check(lab: Laboratory, place: Path) -> str:
    """Check what is on the disk after a kill; return as text when the kill happened."""
    notes = place / "notes"
    noted = [line.split()[1] for line in notes.read_text().splitlines()] if notes.exists() else []
    if not list(place.glob("*_*")):
        assert not noted
        return "before its folder"
    try:
        stored = read(run_in(place))
    except DataError:
        assert not noted
        return "before its header"
    check_recordings(lab, stored)
    stored_names = {recording.name for recording in stored.recordings}
    assert set(noted) <= stored_names, (noted, stored_names)
    return where(stored, run_in(place))


def check_recordings(lab: Laboratory, stored: StoredRun) -> None:
    """Compare each complete recording bit by bit with that of the uninterrupted run."""
    expected_by_hz = {_frequency_hz(each): each for each in lab.undisturbed.recordings}
    for recording in stored.recordings:
        name, expected = recording.name, expected_by_hz[_frequency_hz(recording)]
        assert recording.conditions == expected.conditions
        for channel, values in expected.channels.items():
            assert recording.channels[channel].tobytes() == values.tobytes(), (name, channel)
    for recording in stored.incomplete:
        name, expected = recording.name, expected_by_hz[_frequency_hz(recording)]
        for channel, values in recording.channels.items():
            assert (values == expected.channels[channel][: len(values)]).all(), (name, channel)


def _frequency_hz(recording: Recording) -> float:
    return recording.setpoints["tester.frequency"]


def where(stored: StoredRun, run: Path) -> str:
    if stored.info.sealed:
        return "sealed, with report" if (run / "report.html").exists() else "sealed, no report yet"
    if any(isinstance(event, RunEnded) for event in stored.events):
        return "run over, not sealed"
    steps = [event for event in stored.events if isinstance(event, (StepStarted, StepEnded))]
    if not steps:
        return "in setup"
    if isinstance(steps[-1], StepStarted) and steps[-1].recording:
        return "in a recording"
    phase = steps[-1].step.partition("[")[0]
    return {"setup": "in setup", "main": "between recordings", "teardown": "in teardown"}[phase]


def check_end(lab: Laboratory, place: Path) -> None:
    """Check a run that was finally left to finish."""
    run = run_in(place)
    stored = read(run)
    assert stored.info.sealed
    assert stored.info.outcome == "completed"
    assert len(stored.recordings) == len(lab.undisturbed.recordings)
    check_recordings(lab, stored)
    if not (run / "report.html").exists():
        write_report(run, lab.registry)
    assert numbers(stored.result_document) == numbers(lab.document)
    assert verify_run(run, lab.registry).matches


def kills_of(lab: Laboratory, place: Path, chance: random.Random) -> Iterator[dict[str, str]]:
    """Kill one run, perhaps again while it is resumed, and complete it."""
    place.mkdir()
    if not is_killed(lambda: lab.begin(place), lab.instant_s(chance)):
        return
    where_killed = check(lab, place)
    yield {"what": "run", "where": where_killed}
    for _ in range(WORST_CASE - 1):
        if where_killed.startswith(("before", "sealed")) or chance.random() < GIVES_UP:
            break
        if not is_killed(lambda: lab.resume(place), lab.instant_s(chance)):
            where_killed = "sealed, with report"
            break
        where_killed = check(lab, place)
        yield {"what": "resume", "where": where_killed}
    if where_killed.startswith("before"):
        return
    if not where_killed.startswith("sealed"):
        assert not is_killed(lambda: lab.resume(place), None)
    check_end(lab, place)


def table(kills: list[dict[str, str]]) -> list[str]:
    """Return the lines of a Markdown table: how many kills happened where."""
    counts = Counter((kill["where"], kill["what"]) for kill in kills)
    rows = [(place, counts[place, "run"], counts[place, "resume"]) for place in PLACES]
    totals = ("all", sum(row[1] for row in rows), sum(row[2] for row in rows))
    head = ["| killed | while running | while being resumed |", "|---|---:|---:|"]
    return [*head, *(f"| {place} | {runs} | {again} |" for place, runs, again in (*rows, totals))]


def main() -> None:
    folder, kills, seed = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    lab = Laboratory(folder)
    chance = random.Random(seed)  # noqa: S311  (instants of kills need no secrecy)
    done = number = 0
    while done < kills:
        place = folder / f"place{number:04d}"
        for kill in kills_of(lab, place, chance):
            print(json.dumps(kill), flush=True)  # noqa: T201
            done += 1
        number += 1


if __name__ == "__main__":
    main()
