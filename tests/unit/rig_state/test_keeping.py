"""Files of a rig in use: a cleaner of old files, or a person, may remove them during a run."""

import os
import shutil
import sys
import time

import pytest

from helpers_devices import FakeTester
from helpers_waiting import wait_until
from rigrunner.clock import SimulatedClock
from rigrunner.rig import Rig
from rigrunner.rig_state import (
    Busy,
    Holder,
    Owner,
    RigMarks,
    hold,
    keeping,
    locks,
    read_marker,
    shared_folder,
)
from rigrunner.rig_state.marker import overwrite

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there an open file stays")
OWNER = Owner("press", "/lab/press.yaml", "WEAR", 4711, "bench", "2026-03-01T12:00:00.000Z")
RUN = Holder("press", "WEAR", 4711, "2026-03-01T12:00:00.000Z")
OTHER = Holder("press", "CREEP", 4712, "2026-03-01T13:00:00.000Z")
OLD_S = 40 * 24 * 3600.0


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigs"))
    monkeypatch.setattr(keeping, "TICK_S", 0.01)
    return shared_folder()


@pytest.fixture
def messages():
    return []


@pytest.fixture
def lock(folder):
    return folder / "press.lock"


@pytest.fixture
def energised(lock):
    """Hold an energised rig; yield its marks and the rig."""
    with hold([lock], RUN) as (descriptor,):
        marks = RigMarks(OWNER, ("tester",), {lock: descriptor})
        rig = Rig({"tester": FakeTester()}, SimulatedClock(), marks=marks)
        rig.connect()
        rig.set("tester", "load", 40.0)
        yield marks, rig
        rig.make_safe()


def is_refused(lock):
    try:
        with hold([lock], OTHER):
            return False
    except Busy as busy:
        return busy.holder == RUN


@pytest.mark.parametrize("removed", ["lock", "all files", "the folder"])
def test_removed_files_of_rig_are_recreated(energised, folder, lock, messages, removed):
    marks, rig = energised
    with keeping.keeping(marks, messages.append):
        if removed == "lock":
            lock.unlink()
        elif removed == "all files":
            for path in folder.iterdir():
                path.unlink()
        else:
            shutil.rmtree(folder)
        wait_until(lock.exists)
        wait_until(lambda: locks.is_held(lock) and locks.holder_of(lock) == RUN)
        assert is_refused(lock)
        assert read_marker("press").set_points == "tester.load 40 N"
        rig.set("tester", "load", 50.0)
        assert read_marker("press").set_points == "tester.load 50 N"
    assert any("press.lock was removed during the run and made anew" in text for text in messages)
    assert locks.is_held(lock) is False
    rig.make_safe()
    assert read_marker("press") is None


def test_files_of_rig_in_use_are_touched(energised, folder, lock, messages):
    marks, _ = energised
    files = [lock, folder / "press.json", folder / "press.energised"]
    for path in files:
        os.utime(path, (time.time() - OLD_S,) * 2)
    with keeping.keeping(marks, messages.append):
        wait_until(lambda: all(time.time() - path.stat().st_mtime < 3600.0 for path in files))
    assert messages == []


def test_removed_marker_is_recreated(energised, folder, messages):
    marks, _ = energised
    with keeping.keeping(marks, messages.append):
        (folder / "press.energised").unlink()
        wait_until(lambda: read_marker("press") is not None)
    assert read_marker("press").owner == OWNER


def test_safe_rig_gets_no_marker(energised, folder, lock, messages):
    marks, rig = energised
    rig.make_safe()
    with keeping.keeping(marks, messages.append):
        lock.unlink()
        wait_until(lambda: locks.is_held(lock))
    assert not (folder / "press.energised").exists()


def test_rig_taken_by_another_process_is_reported_once(energised, lock, messages):
    marks, _ = energised
    lock.unlink()
    with hold([lock], OTHER), keeping.keeping(marks, messages.append):
        wait_until(lambda: messages)
        time.sleep(0.1)
    (text,) = messages
    assert "CREEP, process 4712" in text
    assert "two programs may drive the rig" in text


def test_trouble_is_reported_once_and_its_end_not(energised, messages, monkeypatch):
    texts = iter(["", "a lock was removed", "a lock was removed", "", ""])
    calls = []

    def recreate(*_):
        calls.append(1)
        return next(texts, "")

    monkeypatch.setattr(keeping, "_recreate_removed", recreate)
    with keeping.keeping(energised[0], messages.append):
        wait_until(lambda: len(calls) > 5)
    assert messages == ["a lock was removed"]


def test_lock_on_a_disk_that_lost_it_is_recreated(energised, lock, messages, monkeypatch):
    """A network disk may answer that it does not know the open file any more."""
    marks, _ = energised
    fstat, lost = os.fstat, set(marks.locks.values())

    def stale(descriptor):
        if descriptor in lost:
            raise OSError(116, "Stale file handle")
        return fstat(descriptor)

    lock.unlink()
    monkeypatch.setattr(os, "fstat", stale)
    with keeping.keeping(marks, messages.append):
        wait_until(lambda: messages)
        assert locks.is_held(lock)
    assert "press.lock was removed during the run and made anew" in messages[0]


def test_lock_is_not_recreated_without_marker(energised, folder, lock, messages, monkeypatch):
    marks, _ = energised

    def full(_descriptor, _content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("rigrunner.rig_state.marks.overwrite", full)
    with keeping.keeping(marks, messages.append):
        shutil.rmtree(folder)
        wait_until(lambda: messages)
        time.sleep(0.1)
        assert not lock.exists()
        assert len(messages) == 1
        monkeypatch.setattr("rigrunner.rig_state.marks.overwrite", overwrite)
        wait_until(lock.exists)
        assert read_marker("press").set_points == "tester.load 40 N"
