"""Points of a scan that are kept as numbers alone are read back as they were, to the last bit."""

from __future__ import annotations

import math
import struct
from dataclasses import replace
from datetime import UTC

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers_runfile import header_of
from rigrunner.api.errors import DataError
from rigrunner.api.events import Note, RunStarted, Scanned, StepEnded, StepStarted
from rigrunner.bus import Bus, Emitter
from rigrunner.clock import SimulatedClock, utc_text
from rigrunner.runfile import RunWriter, read
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import Kind, read_records
from rigrunner.runfile.loose import read_journal
from rigrunner.runfile.rows import Rows

FIRST = Scanned(
    seq=7, monotonic_s=1.5, utc="2026-03-01T12:00:00.000Z", step="main[0].scan", point=0,
    measurement="friction", setpoints={"a.speed": 1.0, "a.load": 10.0},
    values={"a.load": 9.9, "a.torque": 0.1},
)  # fmt: skip
STEP = {"step": FIRST.step, "index": 0, "action": "scan"}

counts = st.integers(0, 2**32 - 1)
numbers = st.floats(allow_nan=False)


@given(
    counts, numbers, counts, st.lists(numbers, min_size=4, max_size=4),
    st.datetimes(timezones=st.just(UTC)),
)  # fmt: skip
def test_a_point_comes_back_to_the_last_bit(seq, monotonic_s, point, found, when):
    setpoints = dict(zip(FIRST.setpoints, found[:2], strict=True))
    values = dict(zip(FIRST.values, found[2:], strict=True))
    event = replace(
        FIRST, seq=seq, monotonic_s=monotonic_s, point=point, setpoints=setpoints, values=values,
        utc=utc_text(when),
    )  # fmt: skip
    rows = Rows(FIRST)
    again = rows.event_from(rows.bytes_of(event))
    assert again == event
    signs = [math.copysign(1, one) for one in (*again.setpoints.values(), *again.values.values())]
    assert signs == [math.copysign(1, one) for one in found]


@pytest.mark.parametrize(
    "change",
    [
        {"step": "main[1].scan"},
        {"setpoints": {"a.load": 10.0}},
        {"setpoints": {"a.load": 10.0, "a.speed": 1.0}},
        {"values": {"a.torque": 0.1, "a.load": 9.9}},
        {"values": {"a.load": 9.9, "b.torque": 0.1}},
        {"utc": "2026-03-01T12:00:00Z"},
        {"utc": "2026-03-01T12:00:00.0000"},
        {"utc": ""},
        {"seq": 2**32},
        {"point": 2**32},
        {"utc": "2026-03-01T12:00:00.000\N{LATIN SMALL LETTER A WITH DIAERESIS}"},
    ],
)
def test_a_point_of_something_else_is_kept_whole(change):
    assert Rows(FIRST).bytes_of(replace(FIRST, **change)) is None


def test_what_is_no_point_of_this_scan_is_refused():
    rows = Rows(FIRST)
    with pytest.raises(DataError, match="not a point of its scan"):
        rows.event_from(rows.bytes_of(FIRST) + b"1")
    with pytest.raises(DataError, match="not a point of its scan"):
        rows.event_from(rows.bytes_of(FIRST)[:16] + b"\x7f" * 8 + bytes(32))


def scanned(folder, points, at=None):
    """Write a run of two scans; `at`: a note comes in the first of them before that point."""
    emitted = []
    with RunWriter(folder, header_of(folder.name)) as writer:
        emit = Emitter(Bus((*writer.sinks, emitted.append)), SimulatedClock())
        emit(RunStarted, run_id=folder.name, steps=2, estimated_s=1.0)
        for index, names in enumerate((("a.load",), ("a.load", "b.torque"))):
            step = {**STEP, "index": index, "step": f"main[{index}].scan"}
            emit(StepStarted, **step, text="", units={"a.load": "N"})
            for point in range(points):
                if (index, point) == (0, at):
                    emit(Note, step="main[0].scan", text="marginal")
                values = dict.fromkeys(names, 0.5 + point)
                row = {"setpoints": {"a.load": float(point)}, "values": values}
                emit(Scanned, step=step["step"], point=point, measurement="table", **row)
            emit(StepEnded, **step, ok=True)
    return emitted


@pytest.mark.parametrize("at", [None, 0, 2])
def test_the_journal_gives_back_the_events_of_scans_in_their_order(tmp_path, at):
    folder = tmp_path / "run"
    emitted = scanned(folder, 4, at)
    assert list(read_journal(RunFolder(folder)).events) == emitted
    kinds = [one.kind for one in read_records(RunFolder(folder).events)]
    assert kinds.count(Kind.ROW) == 6
    rows = read(folder).measurements
    assert [one.setpoints["a.load"] for one in rows] == [0.0, 1.0, 2.0, 3.0] * 2
    assert [list(one.values) for one in rows] == [["a.load"]] * 4 + [["a.load", "b.torque"]] * 4


def test_a_point_is_stored_by_milliseconds_since_1970_as_journals_that_are_there_have_it():
    stored = struct.unpack("<IdIq4d", Rows(FIRST).bytes_of(FIRST))
    assert stored[:4] == (7, 1.5, 0, 1_772_366_400_000)  # date -d 2026-03-01T12:00Z +%s
    assert stored[4:] == (1.0, 10.0, 9.9, 0.1)
