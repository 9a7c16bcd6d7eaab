"""What the guardian does after the end of its owner, here in the process of the test."""

from __future__ import annotations

import errno
from contextlib import ExitStack
from pathlib import Path

import pytest

from e2e.helpers_supply import GUARDED, SupplyLab
from rigrunner.api.member import Member
from rigrunner.rig_state import DriveMark, Holder, Owner, folder, hold, marker, read_marker
from rigrunner.rig_state.marker import encode
from rigrunner.run.guardian import acting

REASON = "the process of a run (7) died"
SAFE = "the rig is safe: every drive was read back at its safe value"


class EnergisedSupply:
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
        marks = (DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0), *drives)
        (self.locks / "bench.energised").write_bytes(encode(owner, marks, safe_by))


@pytest.fixture
def rig(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    monkeypatch.setattr(acting, "PAUSE_S", 0.0)
    return EnergisedSupply(tmp_path)


@pytest.fixture
def act(rig, capfd):
    """Return a function that lets the guardian act, and returns its output."""

    def act_and_read():
        acting.act(rig.task, REASON)
        return capfd.readouterr().err

    return act_and_read


def test_energised_rig_is_made_safe_and_run_folder_says_so(rig, act):
    rig.run.mkdir()
    rig.mark()
    output = act()
    assert rig.lab.outputs() == (0.0, 0.0)
    for line in (f"{REASON}; last set-points: psu.voltage 40 V", SAFE):
        assert line in output
        for name in ("run.log", "guardian.txt"):
            assert line in (rig.run / name).read_text()
    assert read_marker("bench").safe_by.startswith("The guardian made it safe at 20")


def test_log_of_manual_mode_has_entry_of_guardian(rig, act):
    rig.mark()  # no folder: the log of manual mode, which is a file
    act()
    assert SAFE in rig.run.read_text()


def test_rig_without_run_leaves_files_only_in_its_lab(rig, act, tmp_path, monkeypatch):
    """`Path("")` is the current folder: it is that of no run."""
    rig.run = ""
    rig.mark()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert SAFE in act()
    assert list((tmp_path / "here").iterdir()) == []


def test_rig_not_energised_is_left_alone(rig, act):
    assert f"{REASON}; the rig was not energised" in act()
    rig.mark(safe_by="somebody made it safe")
    assert f"{REASON}; the rig was not energised" in act()
    assert rig.lab.outputs() == (40.0, 20.0)


def test_rig_without_lock_file_is_made_safe(rig, act):
    rig.lock.unlink()
    assert SAFE in act()
    assert rig.lab.outputs() == (0.0, 0.0)


def test_rig_taken_by_another_process_is_left_alone(rig, act):
    rig.mark()
    holder = Holder("bench", "WEAR", 8, "2026-03-01T12:01:00.000Z")
    with ExitStack() as stack:
        stack.enter_context(hold([rig.lock], holder))
        output = act()
    assert "another process has taken the rig (WEAR, process 8): it is left alone" in output
    assert rig.lab.outputs() == (40.0, 20.0)


def test_stuck_drive_is_tried_four_times_then_a_person_is_called(rig, act, monkeypatch):
    rig.run.mkdir()
    rig.mark()
    rig.lab.put(stuck="voltage")
    attempts = []
    attempt = acting._one_attempt
    monkeypatch.setattr(acting, "_one_attempt", lambda *args: attempts.append(1) or attempt(*args))
    output = act()
    assert len(attempts) == 4
    assert "THE RIG IS NOT SAFE: psu" in output
    assert "Go to the rig." in output
    assert "psu is safe" not in output
    assert SAFE not in output
    assert "THE RIG IS NOT SAFE: psu" in (rig.run / "guardian.txt").read_text()
    assert not read_marker("bench").safe_by


def test_attempts_end_once_drive_is_safe(rig, act, monkeypatch):
    rig.mark()
    rig.lab.put(stuck="voltage")
    attempt = acting._one_attempt
    attempts = []

    def free(*args):
        attempts.append(1)
        if len(attempts) == 2:
            rig.lab.put(stuck="")
        return attempt(*args)

    monkeypatch.setattr(acting, "_one_attempt", free)
    assert SAFE in act()
    assert len(attempts) == 2


@pytest.mark.parametrize(("role", "is_safe"), [("psu", False), ("oven", True)])
def test_only_unreachable_energised_device_leaves_rig_unsafe(rig, act, role, is_safe):
    rig.mark()
    rig.task["unreachable"] = [role]
    output = act()
    assert (SAFE in output) is is_safe
    message = f"THE RIG IS NOT SAFE: {role}: its plugin says that no second process can open it"
    assert (message in output) is not is_safe
    assert bool(read_marker("bench").safe_by) is is_safe


def test_name_that_is_not_utf8_is_reported_in_the_run(rig, act, monkeypatch):
    """A message that fails would keep the guardian from making the rig safe."""
    rig.run.mkdir()
    rig.mark()
    monkeypatch.setattr(acting, "_lines", lambda *_: ["no file /lab/\udcff"])
    assert "guardian: no file /lab/?" in act()
    assert "no file /lab/?" in (rig.run / "guardian.txt").read_text()


def test_errors_of_acting_are_reported(rig, act):
    rig.mark()
    rig.task["station_text"] = "rigrunner: station/1\n"
    assert "THE RIG IS NOT SAFE: InvalidFileError" in act()
    rig.task["handed"] = [1, 2]  # more than there are locks
    assert f"{REASON}. THE RIG IS NOT SAFE: ValueError" in act()


@pytest.mark.parametrize("handed", [True, False])
def test_rig_is_made_safe_without_a_folder_for_locks(rig, act, monkeypatch, handed):
    """As after an error of its disk, which the system then mounts read-only."""
    rig.mark()

    def fail(*_, **__):
        raise OSError(errno.EROFS, "Read-only file system")

    with rig.lock.open() as lock:
        rig.task["handed"] = [lock.fileno()] if handed else []
        monkeypatch.setattr(folder.os, "fchmod", fail)
        monkeypatch.setattr(marker, "overwrite", fail)
        output = act()
    assert rig.lab.outputs() == (0.0, 0.0)
    assert SAFE in output
    assert "NOT SAFE" not in output


def test_rig_of_an_unreadable_folder_is_made_safe(rig, act, monkeypatch):
    rig.mark()

    exists = Path.exists

    def fail(path):
        if path.parent == rig.locks:
            raise PermissionError(errno.EACCES, "Permission denied")
        return exists(path)

    monkeypatch.setattr(Path, "exists", fail)
    assert SAFE in act()
    assert rig.lab.outputs() == (0.0, 0.0)


def test_order_of_station_applies_to_reachable_devices(rig, act):
    rig.mark()
    text = rig.task["station_text"].replace("safety: {", "safety: {order: [oven, psu.speed], ")
    oven = "  oven: {type: supply, plugin: supply, settings: {file: oven.json}}\n"
    rig.task["station_text"] = text.replace("instruments:\n", f"{oven}instruments:\n")
    output = act()
    assert SAFE in output
    assert output.index("psu.speed is safe: read back") < output.index("psu is safe: read back")
