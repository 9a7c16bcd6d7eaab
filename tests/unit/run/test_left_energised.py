"""Questions, warnings and records about a rig that may have been left energised."""

from __future__ import annotations

import pytest

from helpers_devices import FakeTester
from rigrunner.api.devices import DriveInfo, Identity
from rigrunner.api.errors import DeviceError, DeviceLostError
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner.rig_state import Owner, RigMarks, read_marker
from rigrunner.run.left_energised import LeftAsItStandsError, check_left

OWNER = Owner("press", "/lab/press.yaml", "WEAR", 4711, "bench", "2026-03-01T12:00:00.000Z")
ACTUAL = "tester.load reads back 700 N, safe is 0 N; tester.frequency reads back 3 Hz, safe is 0 Hz"


class Person:
    by = "A. Tester"

    def __init__(self, *, allows=True):
        self.allows = allows
        self.warnings, self.questions = [], []

    def warn(self, text):
        self.warnings.append(text)

    def agrees(self, question):
        self.questions.append(question)
        return self.allows


class Heater:
    """A device whose only drive can be neither set nor read back."""

    channels = ()
    drives = (DriveInfo("power", "W", "power", 0.0, 100.0),)
    non_blocking = True

    def connect(self, timeout_s):  # noqa: ARG002
        return Identity("Fakes", "heater", "2")

    def make_safe(self):
        return {"power": 0.0}

    def close(self):
        pass


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))


@pytest.fixture
def tester():
    return FakeTester(drives_at={"load": 700.0, "frequency": 3.0})


@pytest.fixture
def check(tester):
    """Return a function that checks the rig like a process that has taken it."""

    def check(person, *roles, reads=True):
        rig_marks = marks(*roles)
        rig = Rig({"tester": tester, "room": Heater()}, SimulatedClock(), marks=rig_marks)
        rig.connect()
        tester.calls.clear()
        return check_left(rig, rig_marks, person, "press.yaml", reads=reads)

    return check


def marks(*roles):
    return RigMarks(OWNER, roles or ("tester", "room"))


def leave_energised(load_n=40.0):
    """Leave the marker of a process that set the load and died."""
    rig_marks = marks()
    rig = Rig({"tester": FakeTester()}, SimulatedClock(), marks=rig_marks)
    rig.connect()
    rig.set("tester", "load", load_n)


def test_safe_rig_causes_no_warning_question_or_action(check, tester):
    tester.drives_at = dict.fromkeys(tester.drives_at, 0.0)
    person = Person()
    assert check(person) == ()
    assert (person.warnings, person.questions) == ([], [])
    assert "make_safe" not in tester.calls


def test_simulated_rig_is_not_read(check, tester):
    rig = Rig({"tester": tester}, SimulatedClock())
    assert check_left(rig, None, Person(), "press.yaml") == ()
    assert tester.calls == []
    assert check(Person(), "room") == ()
    assert tester.calls == []


def test_energised_rig_without_marker_is_made_safe_on_consent(check, tester):
    person = Person()
    (note,) = check(person)
    assert person.warnings == [
        f"the rig is not safe, and no run has said so: {ACTUAL}",
        "the rig was made safe now, and each drive read back at its safe value",
    ]
    (question,) = person.questions
    assert question.startswith("Make the rig safe now?")
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}
    assert (note.action, note.by) == ("found energised", "A. Tester")
    assert note.subject == (
        f"no run had said that the rig is not safe; {ACTUAL}; made safe, and read back"
    )


def test_rig_left_by_another_process_is_reported_and_recorded(check):
    leave_energised()
    person = Person()
    (note,) = check(person)
    assert person.warnings[0] == f"its drives now: {ACTUAL}"
    assert "left energised by WEAR, process 4711" in note.subject
    assert "tester.load 40 N" in note.subject
    assert f"; {ACTUAL}; made safe, and read back" in note.subject


def test_without_consent_nothing_starts_or_moves(check, tester):
    leave_energised()
    with pytest.raises(
        LeftAsItStandsError, match=r"was left as it is: tester\.load reads back 700 N"
    ):
        check(Person(allows=False))
    assert "make_safe" not in tester.calls
    assert not read_marker("press").safe_by


def test_unreadable_drive_is_not_safe(check, tester):
    def fail(call):
        if call == "read_back load":
            raise DeviceLostError("no answer")

    tester.drives_at["frequency"] = 0.0
    tester.before = fail
    person = Person(allows=False)
    with pytest.raises(LeftAsItStandsError):
        check(person)
    (warning,) = person.warnings
    assert "tester.load cannot be read back, safe is 0 N (" in warning
    assert "no answer" in warning
    assert "frequency" not in warning


def test_rig_that_stays_energised_is_refused(check, tester):
    leave_energised()
    tester.read_back_offset = 50.0
    person = Person()
    with pytest.raises(DeviceError, match="the rig is not safe: ") as error:
        check(person)
    assert "devices press.yaml --safe-by NAME" in error.value.hint
    assert not any("was made safe now" in text for text in person.warnings)
    assert not read_marker("press").safe_by


def test_marker_decides_if_nothing_is_read(check, tester):
    assert check(Person(), reads=False) == ()
    assert tester.calls == []
    leave_energised()
    person = Person()
    (note,) = check(person, reads=False)
    assert person.questions == []  # no position is known
    assert "make_safe" in tester.calls
    assert "made safe, and read back" in note.subject


def test_rig_already_made_safe_is_only_recorded(check, tester):
    leave_energised()
    marks().settle("somebody made it safe")
    tester.drives_at = dict.fromkeys(tester.drives_at, 0.0)
    person = Person()
    (note,) = check(person)
    assert (person.warnings, person.questions) == ([], [])
    assert "somebody made it safe" in note.subject
    assert "read back" not in note.subject


def test_missing_device_of_marker_leaves_rig_unsafe():
    leave_energised()
    rig_marks = marks()
    rig = Rig({"room": Heater()}, SimulatedClock(), marks=rig_marks)
    rig.connect()
    with pytest.raises(DeviceError, match="not read back as safe: tester"):
        check_left(rig, rig_marks, Person(), "press.yaml")
