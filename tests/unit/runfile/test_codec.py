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
"""Half of a surrogate pair too, as a file name or an argument may hold one."""


def same(one, other) -> bool:
    """Say whether two JSON documents are equal, not-a-number being equal to itself."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def read_back(event):
    """Return an event as the journal gives it back."""
    kind, data = event_record(event)
    return event_unpacked(data) if kind is Kind.PACKED else event_from(data)


def written(event):
    """Return all fields of an event but the truth, by Python's own encoder."""
    document = {"event": type(event).__name__, **msgspec.structs.asdict(event)}
    document.pop("truth", None)
    return json.loads(json.dumps(document, default=plain))


def plain(value):
    return asdict(value) if is_dataclass(value) else dict(value)


@given(st.dictionaries(any_text, st.floats(), max_size=4), any_text)
def test_journal_and_run_file_have_any_numbers_and_any_text(values, name):
    event = StepEnded(**STAMP, **STEP, values=values, measurement=name, truth={"secret": 1.0})
    assert same(json.loads(event_text(event)), written(event))
    assert same(written(read_back(event)), written(event))


@given(st.floats(allow_nan=False))
def test_a_number_comes_back_to_the_last_bit(value):
    event = RunEnded(**STAMP, outcome=Outcome.COMPLETED, read_back={"press.load": value})
    for again in (read_back(event), event_from(event_text(event))):
        number = again.read_back["press.load"]
        assert (number, math.copysign(1, number)) == (value, math.copysign(1, value))


def test_what_cannot_be_utf_8_is_kept():
    event = Answer(**STAMP, step="setup[0].ask", text="a\udc80b", by="Zoë")
    assert read_back(event) == event


def test_a_mapping_that_is_no_dict_and_a_member_are_kept():
    values = MappingProxyType({Member("press", "torque"): 0.5})
    assert read_back(StepEnded(**STAMP, **STEP, values=values)).values == {"press.torque": 0.5}


def test_text_for_the_run_file_is_ascii_alone():
    assert event_text(Answer(**STAMP, step="s", text="N·m", by="Zoë")).isascii()


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.__name__)
@settings(max_examples=examples(15), deadline=None)
@given(data=st.data())
def test_every_kind_of_event_is_kept_with_its_name_and_all_its_fields(kind, data):
    types = {field.name: st.from_type(field.type) for field in msgspec.structs.fields(kind)}
    event = data.draw(st.builds(kind, **types))
    assert same(json.loads(event_text(event)), written(event))
    assert type(read_back(event)) is kind
    assert same(written(read_back(event)), written(event))


def test_what_a_newer_version_knows_besides_is_passed_over():
    event = Answer(**STAMP, step="s", text="5", by="Zoë")
    document = json.loads(event_text(event)) | {"mood": "fine", "tries": [1]}
    assert event_from(json.dumps(document)) == event
    assert event_unpacked(msgspec.msgpack.encode(document)) == event
    assert event_unpacked(msgspec.msgpack.encode(document | {"event": "Sung"})) is None


def test_a_record_of_another_shape_is_refused_with_its_place():
    document = json.loads(event_text(Answer(**STAMP, step="s", text="5", by="Zoë")))
    for read, write in ((event_from, json.dumps), (event_unpacked, msgspec.msgpack.encode)):
        with pytest.raises(DataError, match=r"is invalid: Answer: .*\$\.seq"):
            read(write(document | {"seq": "third"}))


def test_the_truth_is_in_no_event():
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
def test_a_header_of_an_unknown_format_is_refused(document, message):
    with pytest.raises(DataError, match=message):
        header_from(json.dumps(document).encode(), "the journal")


@given(st.text(max_size=20), any_text)
def test_a_header_of_earlier_versions_has_the_text_of_the_plan(plan, text):
    header = header_of(plan_text=LongText.of(plan), inputs={text: text})
    before = json.dumps({"format": FORMAT, **asdict(header), "plan_text": plan}).encode()
    assert header_from(before, "the journal") == (header, FORMAT)
    read, _ = header_from(header_bytes(header), "the journal")
    assert replace(read, plan_text=header.plan_text) == header
    with pytest.raises(DataError, match="a record of the run is invalid"):
        header_from(before.replace(b'"plan_text": "', b'"plan_text": "\\ud800'), "the journal")


def test_a_block_that_was_cut_off_is_refused():
    block = Block(1000.0, 0, 0.5, {"tester.torque": np.arange(3.0)})
    data = b"".join(block_bytes("001", block))
    name, decoded = block_from(data)
    assert (name, decoded.channels["tester.torque"].tolist()) == ("001", [0.0, 1.0, 2.0])
    for length in (1, len(data) - 1):
        with pytest.raises(DataError, match="a block of samples is invalid"):
            block_from(data[:length])


def test_what_is_no_message_pack_is_refused():
    for data in (b"\xc1", b"", b"\x93\x01"):
        with pytest.raises(DataError, match="a record of the run is not"):
            event_unpacked(data)


def test_what_is_no_json_is_refused_and_ctrl_c_is_not_taken_for_it(monkeypatch):
    with pytest.raises(DataError, match="a record of the run is not JSON"):
        event_from("{")

    def interrupted(_data):
        raise KeyboardInterrupt

    monkeypatch.setattr(json, "loads", interrupted)
    with pytest.raises(KeyboardInterrupt):
        event_from("{")
