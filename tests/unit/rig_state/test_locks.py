"""Locks of a rig: one holder at a time, named, and taken over from a process that died."""

import os
import sys

import pytest

from rigrunner.rig_state import Busy, Holder, hold, is_held, locks, take_over

RUN = Holder("press", "WEAR", 4711, "2026-03-01T12:00:00.000Z")
GUARDIAN = Holder("press", "guardian", 4712, "2026-03-01T12:05:00.000Z")
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="no lock is inherited on Windows")


@pytest.fixture
def lock(tmp_path):
    path = tmp_path / "press.lock"
    path.touch()
    return path


@pytest.fixture
def inherited(lock):
    """Yield a descriptor of the lock that does not hold it (any more)."""
    descriptor = os.open(lock, os.O_RDWR)
    yield descriptor
    os.close(descriptor)


def test_lock_is_held_within_its_context(lock):
    assert is_held(lock) is False
    with hold([lock], RUN):
        assert is_held(lock) is True
    assert is_held(lock) is False
    assert is_held(lock.with_name("none.lock")) is False


def test_busy_error_names_lock_and_holder(lock, tmp_path):
    free = tmp_path / "other.lock"
    with hold([lock], RUN), pytest.raises(Busy) as refused, hold([free, lock], GUARDIAN):
        pass
    assert str(refused.value) == f"{lock} is held"
    assert refused.value.holder == RUN
    assert is_held(free) is False


@POSIX
def test_lock_that_cannot_be_opened_is_not_held(lock, tmp_path):
    link = tmp_path / "link.lock"
    link.symlink_to(lock)
    with hold([lock], RUN):
        assert is_held(link) is False


@POSIX
def test_released_inherited_lock_is_taken_again(lock, inherited):
    with take_over([inherited], [lock], GUARDIAN):
        assert is_held(lock) is True
        with pytest.raises(Busy) as refused, hold([lock], RUN):
            pass
        assert refused.value.holder == GUARDIAN


@POSIX
def test_inherited_lock_taken_by_another_process_is_refused(lock, inherited):
    with (
        hold([lock], RUN),
        pytest.raises(Busy) as refused,
        take_over([inherited], [lock], GUARDIAN),
    ):
        pass
    assert str(refused.value) == f"{lock} is held"
    assert refused.value.holder == RUN


def test_ctrl_c_while_reading_the_holder_is_raised(lock, monkeypatch):
    def interrupted(_path):
        raise KeyboardInterrupt

    monkeypatch.setattr(locks, "read_plain", interrupted)
    with pytest.raises(KeyboardInterrupt):
        locks.holder_of(lock)


@POSIX
def test_ctrl_c_while_taking_a_lock_over_is_raised(lock, inherited, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("fcntl.flock", interrupted)
    with pytest.raises(KeyboardInterrupt), take_over([inherited], [lock], GUARDIAN):
        pass


def test_several_locks_are_held_and_released(lock, tmp_path):
    other = tmp_path / "oven.lock"
    with hold([lock, other], RUN):
        assert [is_held(path) for path in (lock, other)] == [True, True]
        assert locks.holder_of(other) == RUN
    assert [locks.holder_of(path) for path in (lock, other)] == [None, None]


@POSIX
def test_removed_inherited_lock_is_held_by_name_too(lock, inherited):
    """The inherited inode does not lock a new file of the same name."""
    lock.unlink()
    with take_over([inherited], [lock], GUARDIAN):
        assert is_held(lock) is True
        with pytest.raises(Busy), hold([lock], RUN):
            pass
    assert is_held(lock) is False


@POSIX
def test_removed_inherited_lock_taken_by_another_process_is_refused(lock, inherited):
    lock.unlink()
    with (
        hold([lock], RUN),
        pytest.raises(Busy) as refused,
        take_over([inherited], [lock], GUARDIAN),
    ):
        pass
    assert refused.value.holder == RUN
