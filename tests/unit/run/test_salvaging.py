"""One flipped bit costs what it hit, and nothing else; the damaged file stays as it is."""

from __future__ import annotations

import errno
import random
import shutil

import h5py
import numpy as np
import pytest

from e2e.helpers_tamper import ORDER, letterhead
from helpers_cli import call
from helpers_workflow import START
from rigrunner.api.errors import DataError, ExitCode, UsageError
from rigrunner.clock import SimulatedClock
from rigrunner.run.salvaging import damaged_run, salvage
from rigrunner.runfile import read

FLIPS = 24


@pytest.fixture
def copied(tester_runs, tmp_path):
    """Give a copy of a loaded run's folder, with a file that can be written."""
    loaded = tester_runs.loaded
    folder = tmp_path / loaded.name
    folder.mkdir()
    shutil.copyfile(loaded / "run.h5", folder / "run.h5")
    return folder


def flip(path, at, bit=0):
    content = bytearray(path.read_bytes())
    content[at] ^= 1 << bit
    path.write_bytes(content)
    return bytes(content)


def samples_at(path, place):
    """Return where in the file the first chunk of a channel is."""
    with h5py.File(path) as file:
        return file[place].id.get_chunk_info(0).byte_offset + 100


def same(one, other):
    return one.name == other.name and all(
        np.array_equal(np.asarray(one.channels[name]), np.asarray(other.channels[name]))
        for name in other.channels
    )


def hit(copied):
    """Damage the second recording's torque; return the names of the others, and the bytes."""
    sealed = copied / "run.h5"
    with h5py.File(sealed) as file:
        names = sorted(recording.attrs["name"] for recording in file["entry/recordings"].values())
    content = flip(sealed, samples_at(sealed, f"entry/recordings/_{names[1]}/tester_torque"), 3)
    return names, content


def test_show_says_which_recording_is_damaged_and_which_are_sound(copied):
    names, _ = hit(copied)
    shown = call("show", copied)
    assert shown.code == ExitCode.DATA
    assert [line.split()[-1] for line in shown.out.splitlines() if line.startswith("sound")] == [
        names[0], *names[2:],
    ]  # fmt: skip
    assert f"lost: recordings/_{names[1]}/tester_torque: recording: cannot be read" in shown.err
    assert "recover --salvage" in shown.err


def test_what_is_sound_is_saved_in_a_new_run_that_says_what_is_lost(copied, tester_runs):
    names, content = hit(copied)
    intact = {recording.name: recording for recording in read(tester_runs.loaded).recordings}
    done = call("recover", copied, "--salvage", "--by", "A. Jones", "--reason", "bad sector")
    assert done.code == ExitCode.PASS, done.err

    new = copied.with_name(f"{copied.name}_salvaged")
    saved = read(new)
    assert [recording.name for recording in saved.recordings] == [names[0], *names[2:]]
    assert all(same(recording, intact[recording.name]) for recording in saved.recordings)
    assert "tare" in saved.partners
    assert saved.result_document is None
    assert saved.info.outcome == "error"
    salvaged = saved.header.salvaged
    assert salvaged["file"] == f"{copied.name}/run.h5"
    assert salvaged["sha256"] == damaged_run(copied).sha256
    assert salvaged["by"] == "A. Jones"
    assert [name for name in salvaged if name.startswith("lost ")] == [
        f"lost /entry/recordings/_{names[1]}/tester_torque"
    ]
    assert (copied / "run.h5").read_bytes() == content, "the damaged file was written to"
    assert names[1] in call("show", new).err


@pytest.mark.thorough
def test_a_salvaged_run_is_never_certified_and_verify_says_so(copied, tmp_path):
    hit(copied)
    new = salvage(copied, SimulatedClock(START), "A. Jones")
    lab = letterhead(tmp_path / "lab")
    refused = call("certify", new, *ORDER, "--letterhead", lab, "--not-for-certification")
    assert refused.code == ExitCode.DATA
    assert "was salvaged from a damaged file, and is never certified" in refused.err
    verified = call("verify", new)
    assert verified.code == ExitCode.UNDECIDED
    assert "was salvaged from" in verified.out


def test_a_sound_run_is_not_salvaged_and_nothing_is_overwritten(copied):
    with pytest.raises(UsageError, match="is sound: there is nothing to salvage"):
        salvage(copied, SimulatedClock(START), "A. Jones")
    hit(copied)
    salvage(copied, SimulatedClock(START), "A. Jones")
    with pytest.raises(UsageError, match="is never overwritten"):
        salvage(copied, SimulatedClock(START), "A. Jones")


def test_a_salvage_that_fails_leaves_nothing_and_can_be_done_again(copied, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    hit(copied)
    with monkeypatch.context() as patched:
        patched.setattr("rigrunner.runfile.salvage.write_manifest", full)
        with pytest.raises(DataError, match="cannot write"):
            salvage(copied, SimulatedClock(START), "A. Jones")
    assert [path.name for path in copied.parent.iterdir()] == [copied.name]
    assert salvage(copied, SimulatedClock(START), "A. Jones").is_dir()


def test_what_the_manifest_alone_protects_is_not_taken_for_sound(copied):
    """A text has no checksum of HDF5: only the manifest tells that a letter was changed."""
    sealed = copied / "run.h5"
    with h5py.File(sealed) as file:
        at = file["entry/texts/procedure_text"].id.get_offset()
    flip(sealed, at + 10)
    saved = read(salvage(copied, SimulatedClock(START), "A. Jones"))
    assert saved.header.procedure_text == ""
    assert "lost /entry/texts/procedure_text" in saved.header.salvaged
    assert len(saved.recordings) == 5


@pytest.mark.thorough
def test_bits_flipped_anywhere_cost_what_they_hit_and_the_file_stays(copied, tester_runs):
    intact = {recording.name: recording for recording in read(tester_runs.loaded).recordings}
    original = (copied / "run.h5").read_bytes()
    rng = random.Random(19)  # noqa: S311  (seeded, to be repeated)
    saved_at_all = 0
    for _ in range(FLIPS):
        (copied / "run.h5").write_bytes(original)
        content = flip(copied / "run.h5", rng.randrange(len(original)), rng.randrange(8))
        try:
            new = salvage(copied, SimulatedClock(START), "A. Jones")
        except UsageError:
            # nothing is lost: the bit is one that nobody reads, and the run is what it was
            assert read(copied).digest == read(tester_runs.loaded).digest
            continue
        except DataError:
            with pytest.raises(DataError):
                read(copied)
            continue
        finally:
            assert (copied / "run.h5").read_bytes() == content
        saved = read(new)
        names = {recording.name for recording in saved.recordings}
        lost = [name for name in saved.header.salvaged if name.startswith("lost ")]
        assert lost
        assert all(same(recording, intact[recording.name]) for recording in saved.recordings)
        for name in intact.keys() - names:
            assert any(f"/recordings/_{name}" in entry for entry in lost), (name, lost)
        saved_at_all += 1
        shutil.rmtree(new)
    assert saved_at_all >= FLIPS / 2
