"""Samples that were unpacked once are read again from disk, and never wrong whatever that does."""

from __future__ import annotations

import gc
import os
import pickle
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.errors import DataError
from rigrunner.runfile import read, scratch, seal
from rigrunner.runfile.stored_samples import StoredSamples
from unit.runfile.helpers_runfile import recording, write_run

RECORDED = recording(samples=12_500)
PIECE = 1000


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder for what is unpacked, of which nothing is in memory."""
    write_run(tmp_path / "run", [RECORDED])
    seal(tmp_path / "run")
    (tmp_path / "scratch").mkdir()
    monkeypatch.setattr("rigrunner.runfile.entry.IN_MEMORY", 0)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    for module in ("scratch", "stored_samples"):
        monkeypatch.setattr(f"rigrunner.runfile.{module}.PIECE", PIECE)
    monkeypatch.setattr(scratch, "_BYTES", 8 * PIECE)
    return tmp_path / "run"


@pytest.fixture
def unpacked(monkeypatch):
    """Return which slices were unpacked."""
    slices, unpack = [], StoredSamples._unpack

    def noted(self, which):
        slices.append((which.start, which.stop))
        return unpack(self, which)

    monkeypatch.setattr(StoredSamples, "_unpack", noted)
    return slices


def torque(folder):
    return read(folder).recordings[0].channels["tester.torque"]


WANTED = RECORDED.channels["tester.torque"]


def test_what_was_unpacked_is_not_unpacked_again(folder, unpacked):
    values = torque(folder)
    assert values[1500:4200].tolist() == WANTED[1500:4200].tolist()
    assert values[1000:5000].tolist() == WANTED[1000:5000].tolist()
    assert unpacked == [(1000, 5000)]
    assert values[4999:5001].tolist() == WANTED[4999:5001].tolist()
    assert unpacked == [(1000, 5000), (4000, 6000)]


@given(
    slices=st.lists(
        st.tuples(st.integers(0, 12_500), st.integers(0, 4000)), min_size=1, max_size=20
    )
)
@settings(max_examples=examples(30), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_slices_are_those_of_the_recording(folder, slices):
    channels = read(folder).recordings[0].channels
    for begin, count in slices:
        for name, values in channels.items():
            part = slice(begin, begin + count)
            assert values[part].tolist() == RECORDED.channels[name][part].tolist()
    assert values[-7:].tolist() == RECORDED.channels[name][-7:].tolist()
    assert values[100:900:7].tolist() == RECORDED.channels[name][100:900:7].tolist()
    assert values[5000:1000].tolist() == []


def test_whoever_takes_all_has_it_and_none_is_kept(folder, unpacked):
    values = torque(folder)
    assert np.asarray(values).tolist() == WANTED.tolist()
    values[:10]
    assert unpacked == [(None, None), (0, PIECE)]


def test_the_least_and_the_greatest_are_known(folder, unpacked):
    assert torque(folder).limits == (WANTED.min(), WANTED.max())
    assert not unpacked


def open_files():
    return len([*Path("/dev/fd").iterdir()])


@pytest.mark.skipif(sys.platform == "win32", reason="there a name is needed until it is closed")
def test_the_file_has_no_name_and_is_closed_with_the_samples(folder, tmp_path):
    before = open_files()
    values = torque(folder)
    assert open_files() == before, "nothing was asked for yet"
    values[:10]
    assert open_files() == before + 1
    assert not list((tmp_path / "scratch").iterdir())
    del values
    gc.collect()
    assert open_files() == before


def _no_file(**_):
    raise OSError(24, "Too many open files")


def test_without_a_file_samples_are_unpacked_each_time(folder, unpacked, monkeypatch):
    monkeypatch.setattr(tempfile, "TemporaryFile", _no_file)
    values = torque(folder)
    for _ in range(2):
        assert values[:3000].tolist() == WANTED[:3000].tolist()
    assert unpacked == [(0, 3000)] * 2


def test_half_of_what_is_free_is_left(folder, unpacked, monkeypatch):
    left = iter([100_000, 100_000, 76_000, 52_000, 52_000])
    monkeypatch.setattr(scratch, "_free_bytes", lambda: next(left))
    values = torque(folder)
    for begin in (0, 3000, 6000):  # of 24 kB each
        assert values[begin : begin + 3000].tolist() == WANTED[begin : begin + 3000].tolist()
    for begin in (0, 3000, 6000):
        assert values[begin : begin + 3000].tolist() == WANTED[begin : begin + 3000].tolist()
    assert unpacked == [(0, 3000), (3000, 6000), (6000, 9000), (6000, 9000)]


@pytest.mark.parametrize("harm", ["zeros", "shorter"])
def test_what_a_disk_lost_is_unpacked_again(folder, unpacked, harm):
    values = torque(folder)
    values[:3000]
    file = values.scratch._file
    if harm == "zeros":
        file.seek(8 * PIECE * (values.piece + 1) + 4096)
        file.write(bytes(512))
    else:
        file.truncate(100)
    assert values[:3000].tolist() == WANTED[:3000].tolist()
    assert len(unpacked) == 2


def test_a_file_that_changed_or_went_is_told_of_what_is_kept_too(folder):
    values = torque(folder)
    values[:3000]
    values.path.chmod(0o644)
    os.utime(values.path, (1, 1))
    with pytest.raises(DataError, match="was changed while it was read"):
        values[:10]
    values.path.unlink()
    with pytest.raises(DataError, match=f"there is no file {values.path}"):
        values[:10]


def test_another_process_begins_with_its_own(folder):
    values = torque(folder)
    values[:3000]
    copied = pickle.loads(pickle.dumps(values))  # noqa: S301  (our own)
    assert copied[:5000].tolist() == WANTED[:5000].tolist()
    assert copied.scratch is not values.scratch


def test_each_channel_has_as_many_pieces_as_it_needs():
    cache = scratch.Scratch()
    sizes = [scratch.PIECE + 1, 1, scratch.PIECE, 2 * scratch.PIECE, 1]
    assert [cache.room(samples) for samples in sizes] == [0, 2, 3, 4, 6]
