"""What is asked, said and recorded of a rig that may have been left energised."""

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
STANDS = "tester.load reads back 700 N, safe is 0 N; tester.frequency reads back 3 Hz, safe is 0 Hz"


class Asked:
    by = "A. Tester"

    def __init__(self, *, allows=True):
        self.allows = allows
        self.told, self.questions = [], []

    def warn(self, text):
        self.told.append(text)

    def agrees(self, question):
        self.questions.append(question)
        return self.allows


class Heater:
    """A device whose only drive nobody sets: it has no set-point to read back."""

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
    """Look at the rig as a process does that has taken it."""

    def check(person, *roles, reads=True):
        of_rig = marks(*roles)
        rig = Rig({"tester": tester, "room": Heater()}, SimulatedClock(), marks=of_rig)
        rig.connect()
        tester.calls.clear()
        return check_left(rig, of_rig, person, "press.yaml", reads=reads)

    return check


def marks(*roles):
    return RigMarks(OWNER, roles or ("tester", "room"))


def left_by_another(load_n=40.0):
    """Leave the marker of a process that set the load and died."""
    of_it = marks()
    other = Rig({"tester": FakeTester()}, SimulatedClock(), marks=of_it)
    other.connect()
    other.set("tester", "load", load_n)


def test_a_safe_rig_is_neither_told_nor_asked_nor_touched(check, tester):
    tester.drives_at = dict.fromkeys(tester.drives_at, 0.0)
    person = Asked()
    assert check(person) == ()
    assert (person.told, person.questions) == ([], [])
    assert "make_safe" not in tester.calls


def test_a_rig_of_simulators_alone_is_not_looked_at(check, tester):
    rig = Rig({"tester": tester}, SimulatedClock())
    assert check_left(rig, None, Asked(), "press.yaml") == ()
    assert tester.calls == []
    assert check(Asked(), "room") == ()
    assert tester.calls == []


def test_a_rig_that_no_run_left_so_is_told_and_made_safe_once_that_is_allowed(check, tester):
    person = Asked()
    (note,) = check(person)
    assert person.told == [
        f"the rig is not safe, and no run has said so: {STANDS}",
        "the rig was made safe now, and each drive read back at its safe value",
    ]
    (question,) = person.questions
    assert question.startswith("Make the rig safe now?")
    assert tester.drives_at == {"load": 0.0, "frequency": 0.0}
    assert (note.action, note.by) == ("found energised", "A. Tester")
    assert note.subject == (
        f"no run had said that the rig is not safe; {STANDS}; made safe, and read back"
    )


def test_what_another_process_left_is_told_with_its_drives_and_recorded_with_its_marker(check):
    left_by_another()
    person = Asked()
    (note,) = check(person)
    assert person.told[0] == f"its drives now: {STANDS}"
    assert "left energised by WEAR, process 4711" in note.subject
    assert "tester.load 40 N" in note.subject
    assert f"; {STANDS}; made safe, and read back" in note.subject


def test_who_does_not_allow_it_starts_nothing_and_nothing_moves(check, tester):
    left_by_another()
    with pytest.raises(
        LeftAsItStandsError, match=r"was left as it is: tester\.load reads back 700 N"
    ):
        check(Asked(allows=False))
    assert "make_safe" not in tester.calls
    assert not read_marker("press").safe_by


def test_a_drive_that_cannot_be_read_back_is_not_safe(check, tester):
    def fail(call):
        if call == "read_back load":
            raise DeviceLostError("no answer")

    tester.drives_at["frequency"] = 0.0
    tester.before = fail
    person = Asked(allows=False)
    with pytest.raises(LeftAsItStandsError):
        check(person)
    (warning,) = person.told
    assert "tester.load cannot be read back, safe is 0 N (" in warning
    assert "no answer" in warning
    assert "frequency" not in warning


def test_a_rig_that_stays_energised_starts_nothing(check, tester):
    left_by_another()
    tester.read_back_offset = 50.0
    person = Asked()
    with pytest.raises(DeviceError, match="the rig is not safe: ") as error:
        check(person)
    assert "devices press.yaml --safe-by NAME" in error.value.hint
    assert not any("was made safe now" in text for text in person.told)
    assert not read_marker("press").safe_by


def test_where_nothing_is_read_the_marker_counts(check, tester):
    assert check(Asked(), reads=False) == ()
    assert tester.calls == []
    left_by_another()
    person = Asked()
    (note,) = check(person, reads=False)
    assert person.questions == []  # nothing that is known to stand anywhere
    assert "make_safe" in tester.calls
    assert "made safe, and read back" in note.subject


def test_a_rig_that_was_made_safe_before_is_only_put_on_record(check, tester):
    left_by_another()
    marks().settle("somebody made it safe")
    tester.drives_at = dict.fromkeys(tester.drives_at, 0.0)
    person = Asked()
    (note,) = check(person)
    assert (person.told, person.questions) == ([], [])
    assert "somebody made it safe" in note.subject
    assert "read back" not in note.subject


def test_a_device_of_the_marker_that_is_not_there_now_leaves_the_rig_unsafe():
    left_by_another()
    of_rig = marks()
    rig = Rig({"room": Heater()}, SimulatedClock(), marks=of_rig)
    rig.connect()
    with pytest.raises(DeviceError, match="not read back as safe: tester"):
        check_left(rig, of_rig, Asked(), "press.yaml")
