"""Only one run at a time uses a real rig, whoever starts it."""

import dataclasses
import os
import signal
import stat
import subprocess
import sys
from contextlib import suppress

import pytest

from helpers_tester import procedure_file, station_file
from helpers_workflow import START
from rigrunner.api.errors import DeviceError, ExitCode
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry
from rigrunner.rig_state import shared_folder
from rigrunner.run.prepare import plan_run
from rigrunner.run.rig_lock import rig_lock
from rigrunner.tape import RecordedTape, ReplayedTape
from rigrunner.tools.by_hand.station import ready_station

pytestmark = pytest.mark.usefixtures("tester")
HOLD = """
import sys, tempfile
from filelock import FileLock
with FileLock(sys.argv[1], timeout=0):
    print("held", flush=True)
    sys.stdin.read()
"""


class RealDevices:
    """A registry that takes every device for a real one."""

    def __init__(self, registry):
        self._registry = registry

    def __getattr__(self, name):
        return getattr(self._registry, name)

    def is_simulated(self, plugin, settings):  # noqa: ARG002  (the registry's)
        return False


@pytest.fixture(autouse=True)
def own_locks(tmp_path, monkeypatch):
    monkeypatch.setenv("RIGRUNNER_LOCKS", str(tmp_path / "rigrunner-rigs"))


def planned(folder, station_id="press-1", *, simulated=False):
    folder.mkdir(exist_ok=True)
    station = station_file(folder, ("id: bench", f"id: {station_id}"))
    planned = plan_run(
        procedure_file(folder, "idle"), station, load_registry(), SimulatedClock(START)
    )
    registry = planned.registry if simulated else RealDevices(planned.registry)
    return dataclasses.replace(planned, registry=registry)


def test_rig_in_use_is_refused_naming_its_holder(tmp_path):
    rig = planned(tmp_path / "one")
    with (
        rig_lock(rig),
        pytest.raises(DeviceError, match=r"press-1 is in use: T-IDLE, process \d+") as caught,
        rig_lock(rig),
    ):
        pass
    assert caught.value.exit_code is ExitCode.DEVICE


def test_rig_is_free_after_the_run(tmp_path):
    rig = planned(tmp_path / "one")
    for _ in range(2):
        with rig_lock(rig):
            pass


@pytest.mark.skipif(sys.platform == "win32", reason="TMPDIR is of POSIX")
def test_folder_of_locks_does_not_depend_on_tmpdir(monkeypatch, tmp_path):
    monkeypatch.delenv("RIGRUNNER_LOCKS")
    before = shared_folder()
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    assert shared_folder() == before
    assert not shared_folder().is_relative_to(tmp_path)


def test_locks_are_in_public_folder_on_windows(monkeypatch, tmp_path):
    monkeypatch.delenv("RIGRUNNER_LOCKS")
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setenv("PUBLIC", str(tmp_path))
    assert shared_folder() == tmp_path / "rigrunner-rigs"


def test_two_rigs_can_run_concurrently(tmp_path):
    with rig_lock(planned(tmp_path / "one", "press-1")), rig_lock(planned(tmp_path / "two", "b")):
        pass


def test_simulated_rigs_are_not_locked(tmp_path):
    rig = planned(tmp_path / "one", simulated=True)
    with rig_lock(rig), rig_lock(rig):
        pass
    assert not (tmp_path / "rigrunner-rigs").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is of POSIX")
def test_killed_process_releases_its_rig(tmp_path):
    rig = planned(tmp_path / "one")
    command = [sys.executable, "-c", HOLD, str(shared_folder() / "press-1.lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"held\n"
        with pytest.raises(DeviceError, match="is in use "), rig_lock(rig):
            pass
        process.send_signal(signal.SIGKILL)
        process.wait()
    with rig_lock(rig):
        pass


def test_unwritable_lock_is_a_device_error_naming_the_file(tmp_path):
    (tmp_path / "rigrunner-rigs").mkdir()
    (tmp_path / "rigrunner-rigs" / "press-1.lock").mkdir()
    with (
        pytest.raises(DeviceError, match="cannot be locked") as caught,
        rig_lock(planned(tmp_path / "one")),
    ):
        pass
    assert "press-1.lock" in caught.value.hint


def by_hand(folder, tape=None):
    ready = ready_station(station_file(folder, ("id: bench", "id: press-1")), tape=tape)
    return dataclasses.replace(ready, registry=RealDevices(ready.registry))


def test_manual_mode_locks_the_rig(tmp_path):
    rig = planned(tmp_path / "one")
    with (
        by_hand(tmp_path).hold("jog tester"),
        pytest.raises(DeviceError, match=r"press-1 is in use: jog tester, process \d+"),
        rig_lock(rig),
    ):
        pass
    with rig_lock(rig), pytest.raises(DeviceError, match="in use: T-IDLE"):
        by_hand(tmp_path).hold("devices").__enter__()


def test_replay_needs_no_rig(tmp_path):
    with by_hand(tmp_path, RecordedTape(tmp_path / "tape")).hold("devices"):
        pass
    with rig_lock(planned(tmp_path / "one")):
        with by_hand(tmp_path, ReplayedTape(tmp_path / "tape")).hold("devices"):
            pass
        tape = ReplayedTape(tmp_path / "tape")
        with tape, rig_lock(dataclasses.replace(planned(tmp_path / "two"), tape=tape)):
            pass


POSIX = pytest.mark.skipif(sys.platform == "win32", reason="there the folder is a person's own")


@POSIX
def test_other_users_cannot_remove_locks():
    assert stat.S_IMODE(shared_folder().stat().st_mode) == 0o1777
    shared_folder().chmod(0o777)  # as an earlier version made it
    assert stat.S_IMODE(shared_folder().stat().st_mode) == 0o1777


@POSIX
@pytest.mark.parametrize("make_link", ["symlink_to", "hardlink_to"])
def test_link_as_lock_file_changes_no_other_file(tmp_path, make_link):
    """Another user of the machine could have made it."""
    ours = tmp_path / "ours"
    ours.write_text("precious")
    getattr(shared_folder() / "press-1.json", make_link)(ours)
    with rig_lock(planned(tmp_path / "one")):
        pass
    getattr(shared_folder() / "press-2.lock", make_link)(ours)
    with suppress(DeviceError), rig_lock(planned(tmp_path / "two", "press-2")):
        pass
    assert ours.read_text() == "precious"


@POSIX
def test_pipe_as_holder_file_does_not_block(tmp_path):
    os.mkfifo(shared_folder() / "press-1.json")
    with rig_lock(planned(tmp_path / "one")):
        pass


@POSIX
def test_link_as_folder_of_locks_is_refused(tmp_path):
    ours = tmp_path / "ours"
    ours.mkdir(mode=0o700)
    (tmp_path / "rigrunner-rigs").symlink_to(ours)
    with (
        pytest.raises(DeviceError, match="folder for locks"),
        rig_lock(planned(tmp_path / "a")),
    ):
        pass
    assert stat.S_IMODE(ours.stat().st_mode) == 0o700
