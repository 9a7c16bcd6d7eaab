"""A recording in HDF5: names and units of its channels."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.api.member import Member
from rigrunner.runfile.recordings import RecordingFacts, _join, write_recording

TORQUE, COUNTS = Member("tester", "torque"), Member("tester", "counts")


def test_channel_without_a_unit_is_stored_under_its_name():
    facts = RecordingFacts(
        name="001",
        number=1,
        rate_hz=1000.0,
        channels=(TORQUE, COUNTS),
        samples=2,
        started_utc="2026-01-01T00:00:00.000Z",
        complete=True,
        setpoints={},
        units={TORQUE: "N·m"},
        conditions={},
    )
    samples = {TORQUE: np.array([1.0, 2.0]), COUNTS: np.array([3.0, 4.0])}
    with h5py.File("none.h5", "w", driver="core", backing_store=False) as file:
        write_recording(file, facts, [Block(1000.0, 0, 0.0, samples)])
        names = {str(file[name].attrs.get("long_name", "")) for name in file}
    assert names >= {"tester.torque / N·m", "tester.counts"}


def test_block_with_other_channels_is_refused():
    blocks = [Block(1000.0, 0, 0.0, {"torque": np.zeros(2), "angle": np.zeros(2)})]
    assert list(_join(blocks, ("angle", "torque"))) == ["angle", "torque"]
    for names in (("torque",), ("torque", "angle", "load")):
        with pytest.raises(DataError, match=f"other channels than {', '.join(names)}"):
            _join(blocks, names)
