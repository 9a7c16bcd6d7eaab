"""Scan points that an older journal stores as bare numbers are read bit for bit."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import DataError
from rigrunner.api.events import RunStarted, Scanned, StepStarted
from rigrunner.runfile import codec, read
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import JournalWriter, Kind
from rigrunner.runfile.loose import Rows, read_journal
from unit.runfile.helpers_runfile import header_of

FIRST = Scanned(
    seq=7, monotonic_s=1.5, utc="2026-03-01T12:00:00.000Z", step="main[0].scan", point=0,
    measurement="friction", setpoints={"a.speed": 1.0, "a.load": 10.0},
    values={"a.load": 9.9, "a.torque": 0.1},
)  # fmt: skip
NOON_MS = 1_772_366_400_000
"""date -d 2026-03-01T12:00Z +%s, in milliseconds."""


def row(seq, monotonic_s, point, milliseconds, *numbers):
    """Return a point as stored in a record: little-endian, without padding."""
    return struct.pack(f"<IdIq{len(numbers)}d", seq, monotonic_s, point, milliseconds, *numbers)


@given(st.lists(st.floats(allow_nan=False), min_size=5, max_size=5))
def test_scan_point_is_read_bit_for_bit(point):
    event = Rows(FIRST).event_from(row(8, point[0], 1, NOON_MS + 250, *point[1:]))
    assert (event.seq, event.point, event.utc) == (8, 1, "2026-03-01T12:00:00.250Z")
    assert (event.step, event.measurement) == (FIRST.step, FIRST.measurement)
    assert (list(event.setpoints), list(event.values)) == (
        ["a.speed", "a.load"], ["a.load", "a.torque"],
    )  # fmt: skip
    numbers = (event.monotonic_s, *event.setpoints.values(), *event.values.values())
    assert numbers == tuple(point)
    assert [math.copysign(1, x) for x in numbers] == [math.copysign(1, x) for x in point]


def test_invalid_scan_point_is_refused():
    data_of_point, rows = row(8, 1.5, 1, NOON_MS, 1.0, 10.0, 9.9, 0.1), Rows(FIRST)
    for data in (data_of_point + b"1", data_of_point[:16] + b"\x7f" * 8 + bytes(32)):
        with pytest.raises(DataError, match="not a point of its scan"):
            rows.event_from(data)


def test_older_journal_of_a_killed_run_is_read(tmp_path):
    """Events were JSON, and all scan points but the first were bare numbers."""
    folder = RunFolder(tmp_path / "run")
    folder.journal.mkdir(parents=True)
    writer = JournalWriter(folder.events)
    writer.append(Kind.HEADER, codec.header_bytes(header_of("run")))
    stamp = {"seq": 0, "monotonic_s": 0.0, "utc": FIRST.utc}
    step = {"step": FIRST.step, "index": 0, "action": "scan", "text": ""}
    for event in (
        RunStarted(**stamp, run_id="run", steps=1, estimated_s=1.0),
        StepStarted(**stamp, **step, units={"a.load": "N", "a.torque": "N·m"}),
        FIRST,
    ):
        writer.append(Kind.EVENT, codec.event_text(event).encode())
    writer.append(Kind.ROW, row(8, 1.75, 1, NOON_MS + 250, 1.0, 20.0, 19.8, 0.2))
    writer.append(Kind.TRUTH, codec.truth_bytes("002", {"torque_nm": 0.7}))
    writer.close()
    assert read_journal(folder).truth == {"002": {"torque_nm": 0.7}}
    rows = read(tmp_path / "run").measurements
    assert [dict(row.setpoints) for row in rows] == [
        {"a.speed": 1.0, "a.load": 10.0}, {"a.speed": 1.0, "a.load": 20.0},
    ]  # fmt: skip
    assert [row.values["a.torque"] for row in rows] == [0.1, 0.2]
