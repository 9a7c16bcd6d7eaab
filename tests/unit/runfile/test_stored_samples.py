"""A run whose samples are too many for memory is read by slices of its file."""

from __future__ import annotations

import os

import numpy as np
import pytest

from rigrunner.api.errors import DataError
from rigrunner.runfile import read, seal
from rigrunner.runfile.stored_samples import StoredSamples
from unit.runfile.helpers_runfile import recording, write_run

TWO = [recording("001_10Hz"), recording("002_20Hz", seed=2)]


@pytest.fixture(params=["sealed", "not sealed"])
def long_run(request, tmp_path, monkeypatch):
    write_run(tmp_path / "run", TWO)
    if request.param == "sealed":
        seal(tmp_path / "run")
    for module in ("entry", "loose"):
        monkeypatch.setattr(f"rigrunner.runfile.{module}.IN_MEMORY", 1000)
    return tmp_path / "run"


def test_its_samples_stay_in_the_file_until_they_are_asked_for(long_run):
    for stored, original in zip(read(long_run).recordings, TWO, strict=True):
        assert stored.samples == original.samples
        for name, values in stored.channels.items():
            assert isinstance(values, StoredSamples)
            assert values[7:2000].tolist() == original.channels[name][7:2000].tolist()
            np.testing.assert_array_equal(values, original.channels[name])


def test_a_file_that_changes_meanwhile_is_refused(long_run):
    values = next(iter(read(long_run).recordings[0].channels.values()))
    values.path.chmod(0o644)
    os.utime(values.path, (1, 1))
    with pytest.raises(DataError, match="was changed while it was read"):
        values[:10]


def test_a_file_that_is_gone_is_named(long_run):
    values = next(iter(read(long_run).recordings[0].channels.values()))
    values.path.unlink()
    with pytest.raises(DataError, match=f"there is no file {values.path}"):
        values[:10]


def test_ctrl_c_while_samples_are_read_is_not_taken_for_a_lost_file(long_run, monkeypatch):
    values = next(iter(read(long_run).recordings[0].channels.values()))

    def interrupted(_path):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.runfile.stored_samples._state", interrupted)
    with pytest.raises(KeyboardInterrupt):
        np.asarray(values)
