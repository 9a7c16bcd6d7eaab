"""kill -9 at random instants of recording and sealing: nothing finished is lost."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
import pytest

from e2e import helpers_kill
from helpers_devices import RATE_HZ, samples_of
from helpers_docs import ROOT
from rigrunner.api.errors import DataError
from rigrunner.runfile import read, seal
from unit.runfile.helpers_runfile import recording

KILLS = int(os.environ.get("RIGRUNNER_KILLS", "20"))
"""A longer form: RIGRUNNER_KILLS=300 pytest tests/e2e/test_kill.py."""

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="kill -9 needs a Unix")


@pytest.fixture(scope="module")
def killed(tmp_path_factory) -> list[Path]:
    folder = tmp_path_factory.mktemp("kills")
    program = [sys.executable, "-m", "e2e.helpers_kill", str(folder), str(KILLS), "20260301"]
    done = subprocess.run(
        program, cwd=ROOT / "tests", capture_output=True, text=True, check=True, timeout=600
    )
    return [Path(json.loads(line)["folder"]) for line in done.stdout.splitlines()]


def notes_of(place: Path) -> dict[str, list[str]]:
    notes = defaultdict(list)
    path = place / "notes"
    for line in path.read_text().splitlines() if path.exists() else []:
        run_id, what = line.split()
        notes[run_id].append(what)
    return notes


def assert_complete(recording) -> None:
    samples = round(helpers_kill.SECONDS * RATE_HZ)
    for name in ("angle", "torque"):
        values = recording.channels[f"tester.{name}"]
        assert (values == samples_of(name, 0, samples)).all()
        assert len(values) == samples


@pytest.mark.thorough
def test_every_recording_reported_as_finished_is_kept(killed):
    states = Counter()
    for place in killed:
        notes = notes_of(place)
        for folder in sorted(place.glob("run*")):
            reported = notes.get(folder.name, [])
            states[check(folder, reported)] += 1
    print(f"{KILLS} kills: {dict(states)}")  # noqa: T201  (the table, for pytest -s)
    assert sum(states.values()) >= KILLS * 0.9
    assert states["sealed"]
    assert states["journal"]


def check(folder: Path, reported: list[str]) -> str:
    """Check one run folder after the kill, and again after sealing it."""
    try:
        run = read(folder)
    except DataError:
        assert not reported
        with pytest.raises(DataError, match="is not a run"):
            read(folder)
        return "no header yet"
    for stored in run.recordings:
        assert_complete(stored)
    names = [name for name in reported if name != "sealed"]
    assert list(run.info.recording_names)[: len(names)] == names
    assert len(run.recordings) - len(names) <= 1
    if run.info.sealed:
        assert run.info.outcome == "completed"
        return "sealed"
    assert "sealed" not in reported
    seal(folder)
    after = read(folder)
    assert after.info.sealed
    assert after.digest == run.digest
    assert [*after.events] == [*run.events]
    assert [part.samples for part in after.incomplete] == [part.samples for part in run.incomplete]
    return "journal"


FOLDS = """
import os, random, signal, sys, time
from pathlib import Path

from rigrunner.runfile import RunWriter
from unit.runfile.helpers_runfile import emitter_of, end_recording, header_of, recording
from unit.runfile.helpers_runfile import send_samples, start_recording

folder, kills = Path(sys.argv[1]), int(sys.argv[2])
one, lives = recording(samples=200_000), random.Random(20260301)
for number in range(kills):
    told, tell = os.pipe()
    if (writing := os.fork()) == 0:
        writer = RunWriter(folder / f"run{number}", header_of())
        emit = emitter_of(writer)
        start_recording(emit, one)
        send_samples(emit, one, 10_000)
        end_recording(emit, one)
        os.write(tell, b"!")
        writer.close()
        time.sleep(60)
    os.read(told, 1)
    time.sleep(lives.uniform(0.0, 0.15))
    os.kill(writing, signal.SIGKILL)
    os.waitpid(writing, 0)
"""


@pytest.mark.thorough
def test_kill_while_folding_loses_no_sample(tmp_path):
    kills = max(10, KILLS // 2)
    program = [sys.executable, "-c", FOLDS, str(tmp_path), str(kills)]
    subprocess.run(program, cwd=ROOT / "tests", check=True, timeout=300)
    states, original = Counter(), recording(samples=200_000)
    for folder in sorted(tmp_path.glob("run*")):
        files = {path.suffix for path in folder.rglob("0*")}
        states[" ".join(sorted(files))] += 1
        for _ in range(2):
            stored = read(folder)
            assert not stored.incomplete
            (stored_recording,) = stored.recordings
            for name, values in original.channels.items():
                assert np.asarray(stored_recording.channels[name]).tobytes() == values.tobytes()
            if not stored.info.sealed:
                seal(folder)
    print(f"{kills} kills: {dict(states)}")  # noqa: T201  (the table, for pytest -s)
    assert sum(states.values()) == kills
    assert states[".samples .tmp"]  # killed while folding
