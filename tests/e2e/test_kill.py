"""kill -9 at random instants over recording and sealing: nothing that was finished is lost."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

import pytest

import helpers_kill
from helpers_devices import RATE_HZ, samples_of
from rigrunner.api.errors import DataError
from rigrunner.runfile import read, seal

KILLS = int(os.environ.get("RIGRUNNER_KILLS", "20"))
"""A longer form: RIGRUNNER_KILLS=300 pytest tests/e2e/test_kill.py."""

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="kill -9 needs a Unix")


@pytest.fixture(scope="module")
def killed(tmp_path_factory) -> list[Path]:
    folder = tmp_path_factory.mktemp("kills")
    program = [sys.executable, helpers_kill.__file__, str(folder), str(KILLS), "20260301"]
    done = subprocess.run(program, capture_output=True, text=True, check=True, timeout=600)
    return [Path(json.loads(line)["folder"]) for line in done.stdout.splitlines()]


def noted(place: Path) -> dict[str, list[str]]:
    found = defaultdict(list)
    path = place / "notes"
    for line in path.read_text().splitlines() if path.exists() else []:
        run_id, what = line.split()
        found[run_id].append(what)
    return found


def assert_complete(recording) -> None:
    samples = round(helpers_kill.SECONDS * RATE_HZ)
    for name in ("angle", "torque"):
        values = recording.channels[f"tester.{name}"]
        assert (values == samples_of(name, 0, samples)).all()
        assert len(values) == samples


def test_every_recording_that_was_reported_finished_is_there(killed):
    states = Counter()
    for place in killed:
        notes = noted(place)
        for folder in sorted(place.glob("run*")):
            promised = notes.get(folder.name, [])
            states[check(folder, promised)] += 1
    print(f"{KILLS} kills: {dict(states)}")  # noqa: T201  (the table, for pytest -s)
    assert sum(states.values()) >= KILLS * 0.9
    assert states["sealed"]
    assert states["journal"]


def check(folder: Path, promised: list[str]) -> str:
    """Check one run folder as the kill left it, and once more after sealing what is left."""
    try:
        run = read(folder)
    except DataError:
        assert not promised
        with pytest.raises(DataError, match="is not a run"):
            read(folder)
        return "no header yet"
    for recording in run.recordings:
        assert_complete(recording)
    names = [one for one in promised if one != "sealed"]
    assert list(run.info.recording_names)[: len(names)] == names
    assert len(run.recordings) - len(names) <= 1
    if run.info.sealed:
        assert run.info.outcome == "completed"
        return "sealed"
    assert "sealed" not in promised
    seal(folder)
    after = read(folder)
    assert after.info.sealed
    assert after.digest == run.digest
    assert after.events == run.events
    assert [one.samples for one in after.incomplete] == [one.samples for one in run.incomplete]
    return "journal"
