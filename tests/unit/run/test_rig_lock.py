"""One run at a time on a real rig, whoever starts it and however the other one ends."""

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
    """The registry as it is, but that it takes every device for a real one."""

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


def test_a_rig_in_use_is_refused_naming_who_has_it(tmp_path):
    rig = planned(tmp_path / "one")
    with (
        rig_lock(rig),
        pytest.raises(DeviceError, match=r"press-1 is in use: T-IDLE, process \d+") as caught,
        rig_lock(rig),
    ):
        pass
    assert caught.value.exit_code is ExitCode.DEVICE


def test_once_the_run_is_over_the_rig_is_free(tmp_path):
    rig = planned(tmp_path / "one")
    for _ in range(2):
        with rig_lock(rig):
            pass


@pytest.mark.skipif(sys.platform == "win32", reason="TMPDIR is of POSIX")
def test_who_has_temporary_files_of_ones_own_shares_the_locks_all_the_same(monkeypatch, tmp_path):
    monkeypatch.delenv("RIGRUNNER_LOCKS")
    before = shared_folder()
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    assert shared_folder() == before
    assert not shared_folder().is_relative_to(tmp_path)


def test_on_windows_the_locks_are_not_in_the_users_own_folder(monkeypatch, tmp_path):
    monkeypatch.delenv("RIGRUNNER_LOCKS")
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setenv("PUBLIC", str(tmp_path))
    assert shared_folder() == tmp_path / "rigrunner-rigs"


def test_two_rigs_run_side_by_side(tmp_path):
    with rig_lock(planned(tmp_path / "one", "press-1")), rig_lock(planned(tmp_path / "two", "b")):
        pass


def test_simulated_rigs_are_one_per_process_and_not_locked(tmp_path):
    rig = planned(tmp_path / "one", simulated=True)
    with rig_lock(rig), rig_lock(rig):
        pass
    assert not (tmp_path / "rigrunner-rigs").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is of POSIX")
def test_a_killed_process_holds_no_rig(tmp_path):
    rig = planned(tmp_path / "one")
    command = [sys.executable, "-c", HOLD, str(shared_folder() / "press-1.lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"held\n"
        with pytest.raises(DeviceError, match="is in use "), rig_lock(rig):
            pass
        other.send_signal(signal.SIGKILL)
        other.wait()
    with rig_lock(rig):
        pass


def test_a_folder_that_cannot_be_written_is_an_error_of_the_device_and_says_where(tmp_path):
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


def test_by_hand_too_a_rig_is_used_by_one_alone(tmp_path):
    rig = planned(tmp_path / "one")
    with (
        by_hand(tmp_path).hold("jog tester"),
        pytest.raises(DeviceError, match=r"press-1 is in use: jog tester, process \d+"),
        rig_lock(rig),
    ):
        pass
    with rig_lock(rig), pytest.raises(DeviceError, match="in use: T-IDLE"):
        by_hand(tmp_path).hold("devices").__enter__()


def test_what_is_played_back_needs_no_rig(tmp_path):
    with by_hand(tmp_path, RecordedTape(tmp_path / "tape")).hold("devices"):
        pass
    with rig_lock(planned(tmp_path / "one")):
        with by_hand(tmp_path, ReplayedTape(tmp_path / "tape")).hold("devices"):
            pass
        played = ReplayedTape(tmp_path / "tape")
        with played, rig_lock(dataclasses.replace(planned(tmp_path / "two"), tape=played)):
            pass


POSIX = pytest.mark.skipif(sys.platform == "win32", reason="there the folder is a person's own")


@POSIX
def test_nobody_can_remove_the_lock_of_another_person():
    assert stat.S_IMODE(shared_folder().stat().st_mode) == 0o1777
    shared_folder().chmod(0o777)  # as an earlier version made it
    assert stat.S_IMODE(shared_folder().stat().st_mode) == 0o1777


@POSIX
@pytest.mark.parametrize("put", ["symlink_to", "hardlink_to"])
def test_a_link_in_the_folder_of_locks_leads_to_no_file_of_ours(tmp_path, put):
    """As another user of the machine could put it there beforehand."""
    ours = tmp_path / "ours"
    ours.write_text("precious")
    getattr(shared_folder() / "press-1.json", put)(ours)
    with rig_lock(planned(tmp_path / "one")):
        pass
    getattr(shared_folder() / "press-2.lock", put)(ours)
    with suppress(DeviceError), rig_lock(planned(tmp_path / "two", "press-2")):
        pass
    assert ours.read_text() == "precious"


@POSIX
def test_a_pipe_in_place_of_the_holder_keeps_nobody_waiting(tmp_path):
    os.mkfifo(shared_folder() / "press-1.json")
    with rig_lock(planned(tmp_path / "one")):
        pass


@POSIX
def test_a_link_in_place_of_the_folder_opens_no_folder_of_ours(tmp_path):
    ours = tmp_path / "ours"
    ours.mkdir(mode=0o700)
    (tmp_path / "rigrunner-rigs").symlink_to(ours)
    with (
        pytest.raises(DeviceError, match="folder for locks"),
        rig_lock(planned(tmp_path / "a")),
    ):
        pass
    assert stat.S_IMODE(ours.stat().st_mode) == 0o700
