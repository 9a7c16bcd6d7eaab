"""The marker of an energised rig: written before a drive is set, removed once all are safe."""

import os
import shutil
import stat
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from helpers_devices import FakeTester
from rigrunner.api.errors import DeviceError
from rigrunner.api.member import Member
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner.rig_state import (
    Holder,
    Owner,
    RigMarks,
    hold,
    marker,
    marks,
    read_marker,
    read_marker_of_held,
    read_markers,
    record_made_safe,
)
from rigrunner.rig_state import clear as clear_marker

OWNER = Owner(
    station="press",
    station_file="/lab/press.yaml",
    procedure="WEAR",
    process=4711,
    host="bench",
    since="2026-03-01T12:00:00.000Z",
)
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="links and modes are of POSIX")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    return tmp_path / "rigs"


def test_held_rig_without_files_has_unknown_set_points(folder):
    lock = folder / "press.lock"
    folder.mkdir()
    lock.touch()
    assert read_marker_of_held("press", lock) is None
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 500.0)
    assert read_marker_of_held("press", lock).drives[0].set_point == 500.0
    shutil.rmtree(folder)
    assert read_marker("press") is None
    marker = read_marker_of_held("press", lock)
    assert marker.owner is None
    assert marker.set_points == "set-points not known"


def rig_with(marks, *devices):
    return Rig(dict(zip(("tester", "oven"), devices, strict=False)), SimulatedClock(), marks=marks)


def marks_of(*roles):
    return RigMarks(OWNER, roles or ("tester",))


def test_marker_precedes_first_set_and_names_run_and_set_point():
    markers = []

    def look(call):
        if call.startswith("set"):
            markers.append(read_marker("press"))

    marks = marks_of()
    rig = rig_with(marks, FakeTester(before=look))
    rig.connect()
    marks.describe(run="/lab/runs/2026-03-01_wear")
    assert read_marker("press") is None
    rig.set("tester", "load", 40.0)
    (marker,) = markers
    assert marker.set_points == "tester.load 40 N"
    assert "energised by WEAR (run 2026-03-01_wear), process 4711, begun 2026-03-01" in marker.text
    assert "nothing has confirmed since that it is safe" in marker.text


def test_marker_has_last_set_point_of_each_drive():
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    move = rig.setter("tester", "load", None, lambda: None)
    for load in (10.0, 20.0, 30.5):
        move(load)
    rig.set("tester", "frequency", 2.0)  # writes all of them again
    assert read_marker("press").set_points == "tester.load 30.5 N, tester.frequency 2 Hz"
    move(0.0)
    assert read_marker("press").set_points == "tester.load 0 N, tester.frequency 2 Hz"


def test_setting_safe_value_writes_no_marker(folder):
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 0.0)
    assert not folder.exists()


def test_marker_is_cleared_only_by_safe_read_backs():
    stuck = FakeTester()
    rig = rig_with(marks_of("tester", "oven"), FakeTester(), stuck)
    rig.connect()
    rig.set("tester", "load", 40.0)
    rig.set("oven", "load", 50.0)
    stuck.read_back_offset = 45.0
    rig.make_safe()
    assert read_marker("press").set_points == "oven.load 50 N"
    stuck.read_back_offset = 0.0
    rig.make_safe()
    assert read_marker("press") is None
    assert read_markers() == []


def test_setting_after_make_safe_writes_marker_again():
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    move = rig.setter("tester", "load", None, lambda: None)
    move(40.0)
    rig.make_safe()
    move(30.0)
    assert read_marker("press").set_points == "tester.load 30 N"


def test_later_marker_of_another_process_is_not_removed():
    mine = marks_of()
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    mine.put_on_record()
    assert read_marker("press").set_points == "tester.load 40 N"


def test_simulated_device_is_not_marked():
    rig = rig_with(RigMarks(OWNER, ["oven"]), FakeTester(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    assert read_marker("press") is None
    rig.set("oven", "load", 40.0)
    assert read_marker("press").set_points == "oven.load 40 N"


def test_drive_is_not_set_if_marker_cannot_be_written(folder):
    folder.mkdir()
    (folder / "press.energised").mkdir()
    device = FakeTester()
    rig = rig_with(marks_of(), device)
    rig.connect()
    for _ in range(2):  # a second attempt does not set it either
        with pytest.raises(DeviceError, match="marker of the energised rig cannot be written"):
            rig.set("tester", "load", 40.0)
    assert "set load 40" not in device.calls
    rig.set("tester", "load", 0.0)
    assert "set load 0" in device.calls


def cut_off(monkeypatch):
    """Let each write end after 150 bytes, as on a full disk."""
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, content: write(file, content[:150]))


def test_partly_written_first_marker_is_removed_and_sets_no_drive(monkeypatch):
    device = FakeTester()
    rig = rig_with(marks_of(), device)
    rig.connect()
    with monkeypatch.context() as full:
        cut_off(full)
        with pytest.raises(DeviceError, match="the disk is full"):
            rig.set("tester", "load", 40.0)
    assert "set load 40" not in device.calls
    assert read_marker("press") is None
    rig.set("tester", "load", 40.0)
    assert read_marker("press").set_points == "tester.load 40 N"


def test_failed_marking_of_second_drive_keeps_first(monkeypatch):
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    write, writes = os.write, []

    def full_once(file, content):
        writes.append(content)
        return write(file, content[:100] if len(writes) == 1 else content)

    monkeypatch.setattr(os, "write", full_once)
    with pytest.raises(DeviceError, match="the disk is full"):
        rig.set("tester", "frequency", 2.0)
    assert read_marker("press").set_points == "tester.load 40 N"
    rig.set("tester", "load", 50.0)
    assert read_marker("press").set_points == "tester.load 50 N"


def test_torn_marker_of_earlier_run_stays(monkeypatch, left_by_another_run):
    rig = rig_with(left_by_another_run, FakeTester(), FakeTester())
    rig.connect()
    cut_off(monkeypatch)
    with pytest.raises(DeviceError, match="the disk is full"):
        rig.set("tester", "load", 40.0)
    marker = read_marker("press")
    assert marker.owner is None
    assert marker.text == (
        "the rig of station press may be energised: its marker cannot be read, as after a full disk"
        " or a power cut while it was written; nothing has confirmed since that it is safe"
    )


def test_set_point_that_cannot_be_written_is_sent_only_if_safe(folder, monkeypatch):
    device = FakeTester()
    rig = rig_with(marks_of(), device)
    rig.connect()
    rig.set("tester", "load", 40.0)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(DeviceError, match="cannot be written: No space left on device") as refused:
        rig.set("tester", "load", 50.0)
    assert str(folder) in refused.value.hint
    assert "set load 50" not in device.calls
    rig.set("tester", "load", 0.0)
    assert device.drives_at["load"] == 0.0


def test_marker_names_a_run_in_a_folder_that_is_not_utf8():
    marks = marks_of()
    marks.describe(run="/lab/\udcff/runs/1")
    rig = rig_with(marks, FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    assert read_marker("press").owner.run == "/lab/?/runs/1"


def test_marker_made_anew_meanwhile_has_the_set_point_that_is_sent(folder, monkeypatch):
    """`keeping` renews a removed one in a thread, just after a set-point went to the old file."""
    marks = marks_of()
    rig = rig_with(marks, FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)

    class Lock:
        def __enter__(self):
            (folder / "press.energised").unlink()

        def __exit__(self, *_):
            monkeypatch.undo()
            monkeypatch.setenv("RIGRUNNER_LOCKS", str(folder))
            marks.renew()

    monkeypatch.setattr(marks, "_write_lock", Lock())
    rig.set("tester", "load", 50.0)
    assert read_marker("press").set_points == "tester.load 50 N"


def test_rig_is_made_safe_and_settled_without_its_folder(left_by_another_run, monkeypatch):
    rig = rig_with(left_by_another_run, FakeTester(), FakeTester())
    rig.connect()
    with monkeypatch.context() as broken:
        broken.setattr(Path, "is_dir", fail)
        broken.setattr(Path, "exists", fail)
        assert read_marker_of_held("press", Path("press.lock")).owner is None
        assert all(report.safe for report in rig.make_safe())
        left = read_marker("press")
        assert (left.station, left.owner, left.safe_by) == ("press", None, "")
        with pytest.raises(DeviceError, match=r"rigs is not a folder for locks: Input/output"):
            read_markers()
    assert read_marker("press").set_points == "tester.load 40 N, oven.load 50 N"


def fail(_path):
    raise OSError(5, "Input/output error")


@POSIX
def test_symlink_as_marker_means_energised_rig(folder, tmp_path):
    folder.mkdir()
    (folder / "press.energised").symlink_to(tmp_path / "elsewhere")
    marker = read_marker("press")
    assert "may be energised" in marker.text
    assert not marker.is_in_use  # a rig in use causes no alarm


def test_unreadable_marker_leaves_every_device_unconfirmed(folder):
    folder.mkdir()
    (folder / "press.energised").write_bytes(b"{torn")
    assert marks_of("tester", "oven").unconfirmed == {"tester", "oven"}


def test_rig_made_safe_by_guardian_is_confirmed():
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    record_made_safe("press", "The guardian made it safe")
    later = marks_of()
    assert later.unconfirmed == set()
    assert later.left.safe_by.startswith("The guardian made it safe at 20")


def test_device_with_one_unsafe_drive_keeps_marker():
    class Stuck(FakeTester):
        def make_safe(self):
            return super().make_safe() | {"frequency": 5.0}

    marks = marks_of()
    order = (Member("tester", "load"),)
    rig = Rig({"tester": Stuck()}, SimulatedClock(), None, order, marks=marks)
    rig.connect()
    rig.set("tester", "load", 40.0)
    assert [report.safe for report in rig.make_safe()] == [True, False]
    assert read_marker("press") is not None


def test_truncated_marker_means_energised_rig(folder):
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    path = folder / "press.energised"
    content = path.read_bytes()
    for length in (1, 100, len(content) - 8):
        path.write_bytes(content[:length])
        marker = read_marker("press")
        assert marker is not None
        assert "nothing has confirmed since that it is safe" in marker.text
    path.write_bytes(b"")
    assert read_marker("press") is None


KILLED = """
import os, signal, sys
from helpers_devices import FakeTester
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner.rig_state import Owner, RigMarks
owner = Owner("press", "press.yaml", "WEAR", os.getpid(), "bench", "2026-03-01T12:00:00.000Z")
rig = Rig({"tester": FakeTester()}, SimulatedClock(), marks=RigMarks(owner, ["tester"]))
rig.connect()
for load in range(1, 1001):
    rig.set("tester", "load", float(load))
os.kill(os.getpid(), signal.SIGKILL)
"""


@POSIX
def test_killed_process_leaves_its_last_set_point():
    path = os.pathsep.join(folder for folder in sys.path if folder)
    process = subprocess.run(
        [sys.executable, "-c", KILLED], env={**os.environ, "PYTHONPATH": path}, check=False
    )
    assert process.returncode == -9
    assert read_marker("press").set_points == "tester.load 1000 N"


def test_marker_names_who_made_rig_safe_until_cleared():
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    record_made_safe("press", "The guardian made it safe")
    marker = read_marker("press")
    assert marker.safe_by.startswith("The guardian made it safe at 20")
    assert "last set-points: tester.load 40 N; The guardian made it safe at" in marker.text
    clear_marker("press")
    assert read_marker("press") is None


@POSIX
@pytest.mark.parametrize("put", ["symlink_to", "hardlink_to"])
def test_link_as_marker_changes_no_other_file(folder, tmp_path, put):
    ours = tmp_path / "ours"
    ours.write_text("precious")
    folder.mkdir()
    getattr(folder / "press.energised", put)(ours)
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    with pytest.raises(DeviceError, match="cannot be written"):
        rig.set("tester", "load", 40.0)
    assert ours.read_text() == "precious"


@POSIX
def test_marker_is_writable_by_other_users(folder):
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    assert stat.S_IMODE((folder / "press.energised").stat().st_mode) == 0o666


def test_rig_is_in_use_only_while_held_by_its_energising_process(folder):
    """The guardian holds it too while it makes it safe, and the screen must be red then."""
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    lock = folder / "press.lock"
    with hold([lock], Holder("press", "WEAR", OWNER.process, OWNER.since)):
        assert "is energised by WEAR" in read_marker("press").text
    with hold([lock], Holder("press", "guardian", 4712, OWNER.since)):
        assert "was left energised by WEAR" in read_marker("press").text
    assert "was left energised by WEAR" in read_marker("press").text
    assert read_marker("press").is_in_use is False


def test_marker_is_synced_before_first_set(folder, monkeypatch):
    """A power cut right after the set must not lose the marker."""
    on_disk, sizes = {}, []

    def synced(descriptor):
        on_disk[os.fstat(descriptor).st_ino] = os.fstat(descriptor).st_size

    def look(call):
        if call.startswith("set"):
            path = folder / "press.energised"
            sizes.append((on_disk.get(path.stat().st_ino), path.stat().st_size))

    monkeypatch.setattr(os, "fsync", synced)
    rig = rig_with(marks_of(), FakeTester(before=look))
    rig.connect()
    rig.set("tester", "load", 40.0)
    ((synced_size, size),) = sizes
    assert synced_size == size


def test_empty_marker_is_synced_before_removal(folder, monkeypatch):
    """A power cut in between must not bring back the old marker."""
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    path, synced = folder / "press.energised", []

    def sync(descriptor):
        synced.append((os.fstat(descriptor).st_size, path.exists()))

    monkeypatch.setattr(os, "fsync", sync)
    rig.make_safe()
    assert synced == [(0, True)]
    assert not path.exists()


def test_marker_of_safe_rig_is_closed(monkeypatch):
    opened, real_open = [], marks.open_plain

    def open_plain(path, flags):
        opened.append(real_open(path, flags))
        return opened[-1]

    monkeypatch.setattr(marks, "open_plain", open_plain)
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    os.fstat(opened[0])
    rig.make_safe()
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(opened[0])


def test_markers_are_sorted_by_station():
    assert read_markers() == []
    for station in ("press", "bench"):
        rig = rig_with(RigMarks(replace(OWNER, station=station), ["tester"]), FakeTester())
        rig.connect()
        rig.set("tester", "load", 40.0)
    assert [marker.station for marker in read_markers()] == ["bench", "press"]


def test_reading_missing_marker_creates_no_file(folder):
    folder.mkdir()
    assert read_marker("press") is None
    assert list(folder.iterdir()) == []


def test_unreadable_marker_has_unknown_set_points(folder):
    folder.mkdir()
    (folder / "press.energised").write_bytes(b"{")
    assert read_marker("press").set_points == "set-points not known"
    assert "its marker cannot be read" in read_marker("press").text


def test_ctrl_c_while_decoding_a_marker_is_raised(folder, monkeypatch):
    rig = rig_with(marks_of(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)

    def press(_text):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.rig_state.marker.json.loads", press)
    with pytest.raises(KeyboardInterrupt):
        marker.decode("press", (folder / "press.energised").read_bytes())


@pytest.fixture
def left_by_another_run():
    """Leave a rig with two energised devices; return the marks of the next process."""
    rig = rig_with(marks_of("tester", "oven"), FakeTester(), FakeTester())
    rig.connect()
    rig.set("tester", "load", 40.0)
    rig.set("oven", "load", 50.0)
    return RigMarks(replace(OWNER, procedure="REPEAT", process=4712), ["tester", "oven"])


def test_rig_left_energised_is_safe_once_all_devices_are_confirmed(
    left_by_another_run,
):
    marks = left_by_another_run
    assert marks.unconfirmed == {"tester", "oven"}
    marks.confirm(["tester"])
    assert marks.unconfirmed == {"oven"}
    assert read_marker("press").safe_by == ""
    marks.confirm(["oven"])
    assert marks.unconfirmed == set()
    assert read_marker("press").safe_by.startswith("'REPEAT' made it safe (process 4712) at 20")


def test_marker_of_earlier_run_is_removed_once_safe_and_recorded(left_by_another_run):
    marks = left_by_another_run
    marks.put_on_record()
    assert "energised by WEAR" in read_marker("press").text, "it is not known to be safe yet"
    marks.confirm(["tester", "oven"])
    assert read_marker("press") is not None
    marks.put_on_record()
    assert read_marker("press") is None
    assert marks.left is None


def test_confirmation_by_person_covers_all_devices(
    left_by_another_run,
):
    marks = left_by_another_run
    marks.settle("A. Tester says that it is safe: main switch is off")
    assert marks.unconfirmed == set()
    assert "main switch is off (process 4712)" in marks.left.safe_by
    marks.put_on_record()
    assert read_marker("press") is None
