"""Samples decompressed once are cached on disk, and stay right if the cache is damaged."""

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
    """Return the folder of a run whose samples are not kept in memory."""
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
    """Return the list of decompressed slices."""
    slices, unpack = [], StoredSamples._unpack

    def recorder(self, which):
        slices.append((which.start, which.stop))
        return unpack(self, which)

    monkeypatch.setattr(StoredSamples, "_unpack", recorder)
    return slices


def torque(folder):
    return read(folder).recordings[0].channels["tester.torque"]


TORQUE = RECORDED.channels["tester.torque"]


def test_slices_are_unpacked_once(folder, unpacked):
    values = torque(folder)
    assert values[1500:4200].tolist() == TORQUE[1500:4200].tolist()
    assert values[1000:5000].tolist() == TORQUE[1000:5000].tolist()
    assert unpacked == [(1000, 5000)]
    assert values[4999:5001].tolist() == TORQUE[4999:5001].tolist()
    assert unpacked == [(1000, 5000), (4000, 6000)]


@given(
    slices=st.lists(
        st.tuples(st.integers(0, 12_500), st.integers(0, 4000)), min_size=1, max_size=20
    )
)
@settings(max_examples=examples(30), suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_slice_equals_that_of_the_recording(folder, slices):
    channels = read(folder).recordings[0].channels
    for begin, count in slices:
        for name, values in channels.items():
            part = slice(begin, begin + count)
            assert values[part].tolist() == RECORDED.channels[name][part].tolist()
    assert values[-7:].tolist() == RECORDED.channels[name][-7:].tolist()
    assert values[100:900:7].tolist() == RECORDED.channels[name][100:900:7].tolist()
    assert values[5000:1000].tolist() == []


def test_reading_all_samples_caches_nothing(folder, unpacked):
    values = torque(folder)
    assert np.asarray(values).tolist() == TORQUE.tolist()
    values[:10]
    assert unpacked == [(None, None), (0, PIECE)]


def test_minimum_and_maximum_need_no_unpacking(folder, unpacked):
    assert torque(folder).limits == (TORQUE.min(), TORQUE.max())
    assert not unpacked


def open_files():
    return len([*Path("/dev/fd").iterdir()])


@pytest.mark.skipif(sys.platform == "win32", reason="there a name is needed until it is closed")
def test_scratch_file_is_unnamed_and_closed_with_the_samples(folder, tmp_path):
    before = open_files()
    values = torque(folder)
    assert open_files() == before, "no samples requested yet"
    values[:10]
    assert open_files() == before + 1
    assert not list((tmp_path / "scratch").iterdir())
    del values
    gc.collect()
    assert open_files() == before


def _no_file(**_):
    raise OSError(24, "Too many open files")


def test_samples_are_unpacked_each_time_without_a_scratch_file(folder, unpacked, monkeypatch):
    monkeypatch.setattr(tempfile, "TemporaryFile", _no_file)
    values = torque(folder)
    for _ in range(2):
        assert values[:3000].tolist() == TORQUE[:3000].tolist()
    assert unpacked == [(0, 3000)] * 2


def test_ctrl_c_while_reading_scratch_data_is_raised(folder, monkeypatch):
    values, opened = torque(folder), scratch.Scratch._open

    def interrupted(_self):
        monkeypatch.setattr(scratch.Scratch, "_open", opened)
        raise KeyboardInterrupt

    values[:3000]
    monkeypatch.setattr(scratch.Scratch, "_open", interrupted)
    with pytest.raises(KeyboardInterrupt):
        values[:3000]


def test_half_of_the_free_space_is_left(folder, unpacked, monkeypatch):
    left = iter([100_000, 100_000, 76_000, 52_000, 52_000])
    monkeypatch.setattr(scratch, "_free_bytes", lambda: next(left))
    values = torque(folder)
    for begin in (0, 3000, 6000):  # of 24 kB each
        assert values[begin : begin + 3000].tolist() == TORQUE[begin : begin + 3000].tolist()
    for begin in (0, 3000, 6000):
        assert values[begin : begin + 3000].tolist() == TORQUE[begin : begin + 3000].tolist()
    assert unpacked == [(0, 3000), (3000, 6000), (6000, 9000), (6000, 9000)]


@pytest.mark.parametrize("harm", ["zeros", "shorter"])
def test_damaged_scratch_data_are_unpacked_again(folder, unpacked, harm):
    values = torque(folder)
    values[:3000]
    file = values.scratch._file
    if harm == "zeros":
        file.seek(8 * PIECE * (values.piece + 1) + 4096)
        file.write(bytes(512))
    else:
        file.truncate(100)
    assert values[:3000].tolist() == TORQUE[:3000].tolist()
    assert len(unpacked) == 2


def test_changed_or_missing_file_is_reported_for_cached_slices(folder):
    values = torque(folder)
    values[:3000]
    values.path.chmod(0o644)
    os.utime(values.path, (1, 1))
    with pytest.raises(DataError, match="was changed while it was read"):
        values[:10]
    values.path.unlink()
    with pytest.raises(DataError, match=f"there is no file {values.path}"):
        values[:10]


def test_copied_samples_get_their_own_scratch_file(folder):
    values = torque(folder)
    values[:3000]
    copied = pickle.loads(pickle.dumps(values))  # noqa: S301  (our own)
    assert copied[:5000].tolist() == TORQUE[:5000].tolist()
    assert copied.scratch is not values.scratch


def test_each_channel_gets_the_pieces_it_needs():
    cache = scratch.Scratch()
    sizes = [scratch.PIECE + 1, 1, scratch.PIECE, 2 * scratch.PIECE, 1]
    assert [cache.room(samples) for samples in sizes] == [0, 2, 3, 4, 6]
