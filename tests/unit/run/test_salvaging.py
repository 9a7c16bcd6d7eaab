"""A flipped bit loses only what it hit; the damaged file is not changed."""

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
def copy(tester_runs, tmp_path):
    """Return a copy of the folder of a loaded run, with a writable file."""
    loaded = tester_runs.loaded
    folder = tmp_path / loaded.name
    folder.mkdir()
    shutil.copyfile(loaded / "run.h5", folder / "run.h5")
    return folder


def flip(path, offset, bit=0):
    content = bytearray(path.read_bytes())
    content[offset] ^= 1 << bit
    path.write_bytes(content)
    return bytes(content)


def samples_at(path, place):
    """Return an offset in the first chunk of a channel."""
    with h5py.File(path) as file:
        return file[place].id.get_chunk_info(0).byte_offset + 100


def same(one, other):
    return one.name == other.name and all(
        np.array_equal(np.asarray(one.channels[name]), np.asarray(other.channels[name]))
        for name in other.channels
    )


def damage(copy):
    """Damage the second recording's torque; return the names of the others, and the bytes."""
    sealed = copy / "run.h5"
    with h5py.File(sealed) as file:
        names = sorted(recording.attrs["name"] for recording in file["entry/recordings"].values())
    content = flip(sealed, samples_at(sealed, f"entry/recordings/_{names[1]}/tester_torque"), 3)
    return names, content


def test_show_lists_damaged_and_sound_recordings(copy):
    names, _ = damage(copy)
    result = call("show", copy)
    assert result.code == ExitCode.DATA
    assert [line.split()[-1] for line in result.out.splitlines() if line.startswith("sound")] == [
        names[0], *names[2:],
    ]  # fmt: skip
    assert f"lost: recordings/_{names[1]}/tester_torque: recording: cannot be read" in result.err
    assert "recover --salvage" in result.err


def test_salvage_saves_sound_recordings_and_lists_losses(copy, tester_runs):
    names, content = damage(copy)
    intact = {recording.name: recording for recording in read(tester_runs.loaded).recordings}
    result = call("recover", copy, "--salvage", "--by", "A. Jones", "--reason", "bad sector")
    assert result.code == ExitCode.PASS, result.err

    new = copy.with_name(f"{copy.name}_salvaged")
    saved = read(new)
    assert [recording.name for recording in saved.recordings] == [names[0], *names[2:]]
    assert all(same(recording, intact[recording.name]) for recording in saved.recordings)
    assert "tare" in saved.partners
    assert saved.result_document is None
    assert saved.info.outcome == "error"
    salvaged = saved.header.salvaged
    assert salvaged["file"] == f"{copy.name}/run.h5"
    assert salvaged["sha256"] == damaged_run(copy).sha256
    assert salvaged["by"] == "A. Jones"
    assert [name for name in salvaged if name.startswith("lost ")] == [
        f"lost /entry/recordings/_{names[1]}/tester_torque"
    ]
    assert (copy / "run.h5").read_bytes() == content, "the damaged file was written to"
    assert names[1] in call("show", new).err


@pytest.mark.thorough
def test_salvaged_run_is_never_certified(copy, tmp_path):
    damage(copy)
    new = salvage(copy, SimulatedClock(START), "A. Jones")
    lab = letterhead(tmp_path / "lab")
    refused = call("certify", new, *ORDER, "--letterhead", lab, "--not-for-certification")
    assert refused.code == ExitCode.DATA
    assert "was salvaged from a damaged file, and is never certified" in refused.err
    verified = call("verify", new)
    assert verified.code == ExitCode.UNDECIDED
    assert "was salvaged from" in verified.out


def test_sound_run_is_not_salvaged_and_nothing_is_overwritten(copy):
    with pytest.raises(UsageError, match="is sound: there is nothing to salvage"):
        salvage(copy, SimulatedClock(START), "A. Jones")
    damage(copy)
    salvage(copy, SimulatedClock(START), "A. Jones")
    with pytest.raises(UsageError, match="is never overwritten"):
        salvage(copy, SimulatedClock(START), "A. Jones")


def test_failed_salvage_leaves_nothing_and_can_be_repeated(copy, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    damage(copy)
    with monkeypatch.context() as patched:
        patched.setattr("rigrunner.runfile.salvage.write_manifest", full)
        with pytest.raises(DataError, match="cannot write"):
            salvage(copy, SimulatedClock(START), "A. Jones")
    assert [path.name for path in copy.parent.iterdir()] == [copy.name]
    assert salvage(copy, SimulatedClock(START), "A. Jones").is_dir()


def test_damage_found_only_by_the_manifest_is_a_loss(copy):
    """Texts have no checksum of HDF5: only the manifest shows that a letter was changed."""
    sealed = copy / "run.h5"
    with h5py.File(sealed) as file:
        offset = file["entry/texts/procedure_text"].id.get_offset()
    flip(sealed, offset + 10)
    saved = read(salvage(copy, SimulatedClock(START), "A. Jones"))
    assert saved.header.procedure_text == ""
    assert "lost /entry/texts/procedure_text" in saved.header.salvaged
    assert len(saved.recordings) == 5


@pytest.mark.thorough
def test_random_bit_flips_lose_only_what_they_hit(copy, tester_runs):
    intact = {recording.name: recording for recording in read(tester_runs.loaded).recordings}
    original = (copy / "run.h5").read_bytes()
    rng = random.Random(19)  # noqa: S311  (seeded, to be repeated)
    saved_count = 0
    for _ in range(FLIPS):
        (copy / "run.h5").write_bytes(original)
        content = flip(copy / "run.h5", rng.randrange(len(original)), rng.randrange(8))
        try:
            new = salvage(copy, SimulatedClock(START), "A. Jones")
        except UsageError:
            # nothing is lost: the bit is not part of any data
            assert read(copy).digest == read(tester_runs.loaded).digest
            continue
        except DataError:
            with pytest.raises(DataError):
                read(copy)
            continue
        finally:
            assert (copy / "run.h5").read_bytes() == content
        saved = read(new)
        names = {recording.name for recording in saved.recordings}
        lost = [name for name in saved.header.salvaged if name.startswith("lost ")]
        assert lost
        assert all(same(recording, intact[recording.name]) for recording in saved.recordings)
        for name in intact.keys() - names:
            assert any(f"/recordings/_{name}" in entry for entry in lost), (name, lost)
        saved_count += 1
        shutil.rmtree(new)
    assert saved_count >= FLIPS / 2
