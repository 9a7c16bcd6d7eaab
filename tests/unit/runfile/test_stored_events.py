"""The events of a run are held compressed, and come back as they were."""

from __future__ import annotations

import zlib
from math import inf, isnan, nan

import pytest

from benchmarks.frame import allocated_peak
from rigrunner.api.errors import DataError
from rigrunner.api.events import Note, RunStarted, Scanned, StepEnded, StepStarted
from rigrunner.api.limits import ValueLimit
from rigrunner.runfile import stored_events
from rigrunner.runfile.codec import event_text
from rigrunner.runfile.compressed import PART, Compressed, LongText
from rigrunner.runfile.journal import Kind
from rigrunner.runfile.stored_events import StoredEvents


def stamped(seq):
    return {"seq": seq, "monotonic_s": 0.1 * seq, "utc": "2026-03-01T12:00:00.000Z"}


def started(seq, **fields):
    fields = {"action": "measure", "text": "Measure", **fields}
    return StepStarted(**stamped(seq), step=f"main[{seq}]", index=seq, **fields)


def ended(seq, **fields):
    fields = {"action": "measure", "ok": True, **fields}
    return StepEnded(**stamped(seq), step=f"main[{seq}]", index=seq, **fields)


EVERY_KIND = [
    RunStarted(**stamped(0), run_id="run", steps=4, estimated_s=1.0),
    started(1, limits=(ValueLimit("press.torque", None, 3.0, "N·m"),), coordinates={"pass": 1}),
    ended(2, values={"press.torque": 0.25}, measurement="measured"),
    started(3, action="zero"),
    ended(4, action="zero", values={"press.torque": 0.0}),
    started(5, action="scan"),
    Scanned(**stamped(6), step="main[5]", point=0, measurement="m", setpoints={}, values={}),
    started(7, action="record", recording="001"),
    ended(8, action="record", recording="001"),
    Note(**stamped(9), step="main[5]", text="a half \udc80 of a pair"),
]


@pytest.mark.parametrize("piece", [1, 4, 10, 1000])
def test_events_come_back_in_their_order_as_often_as_one_likes(monkeypatch, piece):
    monkeypatch.setattr(stored_events, "_PIECE", piece)
    stored = StoredEvents(EVERY_KIND)
    assert len(stored) == len(EVERY_KIND)
    assert [*stored] == [*stored] == EVERY_KIND
    assert (stored[0], stored[-1]) == (EVERY_KIND[0], EVERY_KIND[-1])
    assert stored[2:4] == tuple(EVERY_KIND[2:4])


def test_values_that_json_lacks_come_back_too():
    stored = StoredEvents([ended(1, values={"press.torque": nan, "press.load": -inf})])
    text = event_text(ended(2, values={"press.torque": nan}))
    assert '"press.torque": NaN' in text
    stored.take(Kind.EVENT, text.encode())
    first, second = stored
    assert isnan(first.values["press.torque"])
    assert first.values["press.load"] == -inf
    assert isnan(second.values["press.torque"])


def test_an_event_of_a_kind_that_is_not_known_is_left_out():
    stored = StoredEvents()
    assert stored.take(Kind.EVENT, b'{"event": "Later", "seq": 1}') is None
    assert (len(stored), [*stored]) == (0, [])


def test_the_outline_has_all_but_steps_that_only_set_or_read():
    outline = StoredEvents(EVERY_KIND).outline
    assert [event.seq for event in outline] == [0, 3, 4, 7, 8, 9]


def test_a_step_takes_a_fraction_of_what_its_events_take():
    def store():
        stored.append(
            StoredEvents(ended(seq, values={"press.torque": seq / 7}) for seq in range(9000))
        )

    stored = []
    assert allocated_peak(store) / 9000 < 250


def test_strings_of_any_length_come_back_in_their_order():
    strings = Compressed()
    assert [*strings] == []
    for part in ([b"", b"a", b"b" * 100], [], [b"\x00\n"], [b""]):
        strings.add(part)
    assert [*strings] == [*strings] == [b"", b"a", b"b" * 100, b"\x00\n", b""]
    assert len(strings) == 5


@pytest.mark.parametrize("size", [0, 1, PART - 1, PART, PART + 1, 3 * PART])
def test_a_long_text_is_the_same_in_whatever_parts_it_came(size):
    data = (b"0123456789\n" * (size // 11 + 1))[:size]
    at_once = LongText([data])
    in_parts = LongText(data[at : at + 999] for at in range(0, size, 999))
    assert at_once == in_parts
    assert b"".join(at_once) == str(at_once).encode() == data
    assert max(map(len, at_once), default=0) <= PART
    assert at_once != LongText([data, b"x"])
    at_once.packed = [zlib.compress(part, 9) for part in at_once]
    assert at_once == in_parts


@pytest.mark.parametrize(
    ("packed", "message"),
    [
        (b"no zlib", "damaged"),
        (zlib.compress(b"text")[:-1], "damaged, or longer than 262,144 bytes"),
        (zlib.compress(bytes(PART + 1)), "damaged, or longer than 262,144 bytes"),
    ],
)
def test_a_part_of_a_long_text_that_is_none_is_refused(packed, message):
    text = LongText()
    text.packed.append(packed)
    with pytest.raises(DataError, match=message):
        str(text)
