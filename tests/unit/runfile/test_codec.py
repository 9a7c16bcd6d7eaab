"""Events as MessagePack and JSON, and back: every field, any number, any text."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, is_dataclass, replace
from types import MappingProxyType

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.api.events import Answer, Outcome, RunEnded, StepEnded
from rigrunner.api.member import Member
from rigrunner.runfile.codec import (
    KINDS,
    block_bytes,
    block_from,
    event_from,
    event_record,
    event_text,
    event_unpacked,
    header_bytes,
    header_from,
)
from rigrunner.runfile.compressed import LongText
from rigrunner.runfile.journal import Kind
from rigrunner.runfile.model import FORMAT
from unit.runfile.helpers_runfile import header_of

STAMP = {"seq": 3, "monotonic_s": 1.25, "utc": "2026-03-01T12:00:00.000Z"}
STEP = {"step": "main[0].measure", "index": 0, "action": "measure", "ok": True}
any_text = st.text(st.characters(exclude_categories=()), max_size=20)
"""Lone surrogates too, as a file name or an argument may hold one."""


def equal_json(one, other) -> bool:
    """Say whether two JSON documents are equal, not-a-number being equal to itself."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def read_back(event):
    """Return an event as read back from the journal."""
    kind, data = event_record(event)
    return event_unpacked(data) if kind is Kind.PACKED else event_from(data)


def fields_of(event):
    """Return all fields of an event except the truth, by Python's own encoder."""
    document = {"event": type(event).__name__, **msgspec.structs.asdict(event)}
    document.pop("truth", None)
    return json.loads(json.dumps(document, default=as_dict))


def as_dict(value):
    return asdict(value) if is_dataclass(value) else dict(value)


@given(st.dictionaries(any_text, st.floats(), max_size=4), any_text)
def test_any_numbers_and_text_round_trip(values, name):
    event = StepEnded(**STAMP, **STEP, values=values, measurement=name, truth={"secret": 1.0})
    assert equal_json(json.loads(event_text(event)), fields_of(event))
    assert equal_json(fields_of(read_back(event)), fields_of(event))


@given(st.floats(allow_nan=False))
def test_numbers_round_trip_bit_for_bit(value):
    event = RunEnded(**STAMP, outcome=Outcome.COMPLETED, read_back={"press.load": value})
    for event_back in (read_back(event), event_from(event_text(event))):
        number = event_back.read_back["press.load"]
        assert (number, math.copysign(1, number)) == (value, math.copysign(1, value))


def test_text_that_is_not_utf_8_is_kept():
    event = Answer(**STAMP, step="setup[0].ask", text="a\udc80b", by="Zoë")
    assert read_back(event) == event


def test_mapping_proxy_and_member_are_kept():
    values = MappingProxyType({Member("press", "torque"): 0.5})
    assert read_back(StepEnded(**STAMP, **STEP, values=values)).values == {"press.torque": 0.5}


def test_text_for_the_run_file_is_ascii():
    assert event_text(Answer(**STAMP, step="s", text="N·m", by="Zoë")).isascii()


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.__name__)
@settings(max_examples=examples(15), deadline=None)
@given(data=st.data())
def test_every_kind_of_event_round_trips(kind, data):
    types = {field.name: st.from_type(field.type) for field in msgspec.structs.fields(kind)}
    event = data.draw(st.builds(kind, **types))
    assert equal_json(json.loads(event_text(event)), fields_of(event))
    assert type(read_back(event)) is kind
    assert equal_json(fields_of(read_back(event)), fields_of(event))


def test_unknown_fields_and_events_are_ignored():
    event = Answer(**STAMP, step="s", text="5", by="Zoë")
    document = json.loads(event_text(event)) | {"mood": "fine", "tries": [1]}
    assert event_from(json.dumps(document)) == event
    assert event_unpacked(msgspec.msgpack.encode(document)) == event
    assert event_unpacked(msgspec.msgpack.encode(document | {"event": "Sung"})) is None


def test_invalid_record_is_refused_with_its_field():
    document = json.loads(event_text(Answer(**STAMP, step="s", text="5", by="Zoë")))
    for read, write in ((event_from, json.dumps), (event_unpacked, msgspec.msgpack.encode)):
        with pytest.raises(DataError, match=r"is invalid: Answer: .*\$\.seq"):
            read(write(document | {"seq": "third"}))


def test_stored_events_do_not_contain_the_truth():
    event = StepEnded(**STAMP, **STEP, truth={"secret": 1.0})
    assert b"secret" not in event_record(event)[1]
    assert "secret" not in event_text(event)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"run_id": "a"}, "the journal does not state its format"),
        ({"format": FORMAT + 1}, "the journal was written by a newer version of Rigrunner"),
    ],
)
def test_header_of_an_unknown_format_is_refused(document, message):
    with pytest.raises(DataError, match=message):
        header_from(json.dumps(document).encode(), "the journal")


@given(st.text(max_size=20), any_text)
def test_header_of_earlier_versions_contains_the_plan(plan, text):
    header = header_of(plan_text=LongText.of(plan), inputs={text: text})
    text_before = json.dumps({"format": FORMAT, **asdict(header), "plan_text": plan}).encode()
    assert header_from(text_before, "the journal") == (header, FORMAT)
    read, _ = header_from(header_bytes(header), "the journal")
    assert replace(read, plan_text=header.plan_text) == header
    with pytest.raises(DataError, match="a record of the run is invalid"):
        header_from(text_before.replace(b'"plan_text": "', b'"plan_text": "\\ud800'), "the journal")


def test_truncated_block_is_refused():
    block = Block(1000.0, 0, 0.5, {"tester.torque": np.arange(3.0)})
    data = b"".join(block_bytes("001", block))
    name, decoded = block_from(data)
    assert (name, decoded.channels["tester.torque"].tolist()) == ("001", [0.0, 1.0, 2.0])
    for length in (1, len(data) - 1):
        with pytest.raises(DataError, match="a block of samples is invalid"):
            block_from(data[:length])


def test_invalid_message_pack_is_refused():
    for data in (b"\xc1", b"", b"\x93\x01"):
        with pytest.raises(DataError, match="a record of the run is not"):
            event_unpacked(data)


def test_invalid_json_is_refused_but_ctrl_c_passes(monkeypatch):
    with pytest.raises(DataError, match="a record of the run is not JSON"):
        event_from("{")

    def interrupted(_data):
        raise KeyboardInterrupt

    monkeypatch.setattr(json, "loads", interrupted)
    with pytest.raises(KeyboardInterrupt):
        event_from("{")


def test_ctrl_c_while_converting_a_record_is_raised(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(msgspec, "convert", interrupted)
    with pytest.raises(KeyboardInterrupt):
        event_from("[]")
