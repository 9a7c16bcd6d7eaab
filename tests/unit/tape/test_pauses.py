"""A replayed pause ends as the recorded one: by a decision, no answer, or an interlock."""

from __future__ import annotations

import pytest

from rigrunner.api.errors import AbortedError, DeviceRejectedError
from rigrunner.engine import Choice, Decision, Paused
from rigrunner.tape.file import TapeFile
from rigrunner.tape.pauses import RecordedPauses, ReplayedPauses
from rigrunner.tape.recording import RecordingWire, Trouble
from rigrunner.tape.replaying import Replay, ReplayWire

PAUSED = Paused("main[0]", "main[0]", "pause requested", (), tuple(Choice))
RESUME = Decision(Choice.RESUME, "A. Jones")


class Person:
    """Watches for a number of looks, then decides."""

    def __init__(self, looks, decision):
        self.looks = looks
        self.decision = decision

    def requested_by(self):
        return "keyboard"

    def decide(self, paused, watch):
        assert paused is PAUSED
        for _ in range(self.looks):
            watch()
        if isinstance(self.decision, Exception):
            raise self.decision
        return self.decision


class Watch:
    """Interlocks that trip at the given look."""

    def __init__(self, trips_at=0):
        self.trips_at = trips_at
        self.looks = 0

    def __call__(self):
        self.looks += 1
        if self.looks == self.trips_at:
            raise AbortedError("too hot", by="interlock overheated")


@pytest.fixture
def replayed(tmp_path):
    tapes = []

    def make(person, watch):
        wire = RecordingWire(tmp_path / "clock.jsonl", Trouble())
        recorded = RecordedPauses(person, wire)
        requested_by = recorded.requested_by()
        decided = outcome(recorded, watch)
        wire.close()
        tapes.append(TapeFile(tmp_path / "clock.jsonl"))
        replay = ReplayWire(tapes[-1], Replay(), 10.0)
        assert ReplayedPauses(replay).requested_by() == requested_by == "keyboard"
        return decided, replay

    yield make
    for tape in tapes:
        tape.close()


def outcome(pauses, watch):
    try:
        return pauses.decide(PAUSED, watch)
    except AbortedError as error:
        return str(error), error.by


@pytest.mark.parametrize(
    ("decision", "trips_at", "expected", "looks"),
    [
        (RESUME, 0, RESUME, 4),
        (AbortedError("nobody answered", by="nobody"), 0, ("nobody answered", "nobody"), 4),
        (RESUME, 3, ("too hot", "interlock overheated"), 3),
    ],
    ids=["decision", "nobody", "interlock"],
)
def test_replayed_pause_has_the_recorded_decision_and_looks(
    replayed, decision, trips_at, expected, looks
):
    decided, replay = replayed(Person(4, decision), Watch(trips_at))
    assert decided == expected
    watch = Watch(trips_at)
    assert outcome(ReplayedPauses(replay), watch) == expected
    assert watch.looks == looks
    assert replay.unrequested() == ""


def test_pause_that_is_not_on_the_tape_is_a_difference(replayed):
    _, replay = replayed(Person(0, RESUME), Watch())
    pauses = ReplayedPauses(replay)
    pauses.decide(PAUSED, Watch())
    assert pauses.requested_by() == ""
    with pytest.raises(DeviceRejectedError, match="the tape is over"):
        pauses.decide(PAUSED, Watch())
