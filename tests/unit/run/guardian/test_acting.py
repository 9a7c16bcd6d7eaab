"""What the guardian does after its owner, done here in the process of the test."""

from __future__ import annotations

from contextlib import ExitStack

import pytest

from e2e.helpers_supply import GUARDED, SupplyLab
from rigrunner.api.member import Member
from rigrunner.rig_state import DriveMark, Holder, Owner, hold, read_marker
from rigrunner.rig_state.marker import encode
from rigrunner.run.guardian import acting

REASON = "the process of a run (7) died"
SAFE = "the rig is safe: every drive was read back at its safe value"


class Left:
    """A supply that a dead process left at 40 V and 20 Hz."""

    def __init__(self, folder):
        self.lab = SupplyLab(folder / "lab", "bench")
        self.lab.put(voltage=40.0, speed=20.0)
        self.locks = folder / "rigs"
        self.locks.mkdir()
        self.lock = self.locks / "bench.lock"
        self.lock.touch()
        self.run = folder / "run"
        self.task = {
            "process": 7,
            "what": "a run",
            "station": "bench",
            "station_file": str(self.lab.station),
            "station_text": self.lab.add_station("guarded.yaml", "bench", GUARDED).read_text(),
            "roles": ["psu"],
            "unreachable": [],
            "locks": [str(self.lock)],
            "handed": [],
        }

    def mark(self, *drives, safe_by=""):
        owner = Owner("bench", "bench.yaml", "STEPS", 7, "pc", "2026-03-01T12:00:00.000Z")
        owner = Owner(**{**vars(owner), "run": str(self.run)})
        left = (DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0), *drives)
        (self.locks / "bench.energised").write_bytes(encode(owner, left, safe_by))


@pytest.fixture
def left(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    monkeypatch.setattr(acting, "PAUSE_S", 0.0)
    return Left(tmp_path)


@pytest.fixture
def act(left, capfd):
    """Let the guardian act, and return what it said."""

    def done():
        acting.act(left.task, REASON)
        return capfd.readouterr().err

    return done


def test_an_energised_rig_is_made_safe_and_that_is_noted_in_the_folder_of_its_run(left, act):
    left.run.mkdir()
    left.mark()
    output = act()
    assert left.lab.stands() == (0.0, 0.0)
    for line in (f"{REASON}; last set-points: psu.voltage 40 V", SAFE):
        assert line in output
        for name in ("run.log", "guardian.txt"):
            assert line in (left.run / name).read_text()
    assert read_marker("bench").safe_by.startswith("The guardian made it safe at 20")


def test_what_was_done_by_hand_has_it_in_its_log(left, act):
    left.mark()  # no folder: the log of manual mode, which is a file
    act()
    assert SAFE in left.run.read_text()


def test_a_rig_that_is_not_energised_is_left_alone(left, act):
    assert f"{REASON}; the rig was not energised" in act()
    left.mark(safe_by="somebody made it safe")
    assert f"{REASON}; the rig was not energised" in act()
    assert left.lab.stands() == (40.0, 20.0)


def test_without_its_files_a_rig_is_made_safe_as_if_energised(left, act):
    left.lock.unlink()
    assert SAFE in act()
    assert left.lab.stands() == (0.0, 0.0)


def test_a_rig_that_another_process_has_taken_is_left_alone(left, act):
    left.mark()
    holder = Holder("bench", "WEAR", 8, "2026-03-01T12:01:00.000Z")
    with ExitStack() as stack:
        stack.enter_context(hold([left.lock], holder))
        output = act()
    assert "another process has taken the rig (WEAR, process 8): it is left alone" in output
    assert left.lab.stands() == (40.0, 20.0)


def test_a_drive_that_stays_is_tried_four_times_and_a_person_is_sent_there(left, act, monkeypatch):
    left.run.mkdir()
    left.mark()
    left.lab.put(stuck="voltage")
    attempts = []
    attempt = acting._one_attempt
    monkeypatch.setattr(acting, "_one_attempt", lambda *args: attempts.append(1) or attempt(*args))
    output = act()
    assert len(attempts) == 4
    assert "THE RIG IS NOT SAFE: psu" in output
    assert "Go to the rig." in output
    assert SAFE not in output
    assert "THE RIG IS NOT SAFE: psu" in (left.run / "guardian.txt").read_text()
    assert not read_marker("bench").safe_by


def test_a_drive_that_obeys_at_last_is_not_tried_again(left, act, monkeypatch):
    left.mark()
    left.lab.put(stuck="voltage")
    attempt = acting._one_attempt
    attempts = []

    def free(*args):
        attempts.append(1)
        if len(attempts) == 2:
            left.lab.put(stuck="")
        return attempt(*args)

    monkeypatch.setattr(acting, "_one_attempt", free)
    assert SAFE in act()
    assert len(attempts) == 2


@pytest.mark.parametrize(("role", "is_safe"), [("psu", False), ("oven", True)])
def test_only_an_energised_device_that_cannot_be_opened_leaves_the_rig_unsafe(
    left, act, role, is_safe
):
    left.mark()
    left.task["unreachable"] = [role]
    output = act()
    assert (SAFE in output) is is_safe
    message = f"THE RIG IS NOT SAFE: {role}: its plugin says that no second process can open it"
    assert (message in output) is not is_safe
    assert bool(read_marker("bench").safe_by) is is_safe


def test_whatever_keeps_it_from_acting_is_told(left, act):
    left.mark()
    left.task["station_text"] = "rigrunner: station/1\n"
    assert "THE RIG IS NOT SAFE: InvalidFileError" in act()
    left.task["handed"] = [1, 2]  # more than there are locks
    assert f"{REASON}. THE RIG IS NOT SAFE: ValueError" in act()


def test_the_order_of_the_station_holds_as_far_as_its_devices_can_be_reached(left, act):
    left.mark()
    text = left.task["station_text"].replace("safety: {", "safety: {order: [oven, psu.speed], ")
    oven = "  oven: {type: supply, plugin: supply, settings: {file: oven.json}}\n"
    left.task["station_text"] = text.replace("instruments:\n", f"{oven}instruments:\n")
    output = act()
    assert SAFE in output
    assert output.index("psu.speed is safe: read back") < output.index("psu is safe: read back")
