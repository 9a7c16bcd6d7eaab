"""The quick way to write an event says the same as the plain one."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic_core import to_json

from rigrunner.api.data import Block
from rigrunner.api.errors import DataError
from rigrunner.api.events import Answer, Outcome, RunEnded, StepEnded
from rigrunner.runfile.codec import (
    _KINDS,
    block_bytes,
    block_from,
    event_bytes,
    event_from,
    event_text,
    header_from,
    plain_event_bytes,
)
from rigrunner.runfile.model import FORMAT

STAMP = {"seq": 3, "monotonic_s": 1.25, "utc": "2026-03-01T12:00:00.000Z"}
STEP = {"step": "main[0].measure", "index": 0, "action": "measure", "ok": True}
any_text = st.text(st.characters(exclude_categories=()), max_size=20)
"""Half of a surrogate pair too, as a file name or an argument may hold one."""


def same(one, other) -> bool:
    """Say whether two JSON documents are equal, not-a-number being equal to itself."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


@given(st.dictionaries(any_text, st.floats(), max_size=4), any_text)
def test_journal_and_run_file_say_of_any_values_what_json_says(values, name):
    event = StepEnded(**STAMP, **STEP, values=values, measurement=name, truth={"secret": 1.0})
    plain = {"event": "StepEnded", **asdict(event)}
    del plain["truth"]
    for quick in (event_bytes(event), event_text(event)):
        assert same(json.loads(quick), json.loads(json.dumps(plain)))


@given(st.floats(allow_nan=False))
def test_a_number_comes_back_to_the_last_bit(value):
    event = RunEnded(**STAMP, outcome=Outcome.COMPLETED, read_back={"press.load": value})
    found = event_from(event_bytes(event)).read_back["press.load"]
    assert (found, math.copysign(1, found)) == (value, math.copysign(1, value))


def test_what_cannot_be_utf_8_is_kept():
    event = Answer(**STAMP, step="setup[0].ask", text="a\udc80b", by="Zoë")
    assert event_from(event_bytes(event)) == event


def test_a_mapping_that_is_no_dict_is_kept():
    event = StepEnded(**STAMP, **STEP, values=MappingProxyType({"press.torque": 0.5}))
    assert event_from(event_bytes(event)).values == {"press.torque": 0.5}


def test_text_for_the_run_file_is_ascii_alone():
    assert event_text(Answer(**STAMP, step="s", text="N·m", by="Zoë")).isascii()


@given(st.dictionaries(any_text, st.floats(), max_size=4), any_text, st.booleans())
def test_the_quick_encoder_says_what_the_plain_one_does(values, text, ok):
    known = {**STEP, "step": text, "ok": ok, "setpoints": values, "values": values}
    event = StepEnded(**STAMP, **known)
    assert same(json.loads(event_bytes(event)), json.loads(plain_event_bytes(event)))


@given(st.dictionaries(st.text(max_size=9), st.floats(), max_size=4), st.text(max_size=9))
def test_usual_events_are_written_quickly_byte_by_byte_as_by_the_general_encoder(values, text):
    event = StepEnded(**STAMP, **STEP, values=values, measurement=text)
    document = {"event": "StepEnded", **vars(event)}
    del document["truth"]
    if "\N{REPLACEMENT CHARACTER}" not in text + "".join(values):
        assert event_bytes(event) == to_json(document)


@pytest.mark.parametrize("kind", _KINDS.values(), ids=lambda one: one.__name__)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_every_kind_of_event_is_written_quickly_and_as_plainly(kind, data):
    event = data.draw(st.from_type(kind))
    assert same(json.loads(event_bytes(event)), json.loads(plain_event_bytes(event)))


def test_what_a_newer_version_knows_besides_is_passed_over():
    event = Answer(**STAMP, step="s", text="5", by="Zoë")
    document = json.loads(event_bytes(event)) | {"mood": "fine", "tries": [1]}
    assert event_from(json.dumps(document)) == event


def test_a_record_of_another_shape_is_refused_with_its_place():
    document = json.loads(event_bytes(Answer(**STAMP, step="s", text="5", by="Zoë")))
    with pytest.raises(DataError, match=r"not what it should be: Answer seq"):
        event_from(json.dumps(document | {"seq": "third"}))


def test_the_truth_is_in_no_event():
    event = StepEnded(**STAMP, **STEP, truth={"secret": 1.0})
    assert b"secret" not in event_bytes(event)
    assert b"secret" not in plain_event_bytes(event)


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ({"run_id": "a"}, "the journal does not say in which format it is"),
        ({"format": FORMAT + 1}, "the journal was written by a newer version of Rigrunner"),
    ],
)
def test_a_header_of_an_unknown_format_is_refused(document, told):
    with pytest.raises(DataError, match=told):
        header_from(json.dumps(document).encode(), "the journal")


def test_a_block_that_was_cut_off_is_refused():
    block = Block(1000.0, 0, 0.5, {"tester.torque": np.arange(3.0)})
    whole = b"".join(block_bytes("001", block))
    name, found = block_from(whole)
    assert (name, found.channels["tester.torque"].tolist()) == ("001", [0.0, 1.0, 2.0])
    for length in (1, len(whole) - 1):
        with pytest.raises(DataError, match="a block of samples is not what it should be"):
            block_from(whole[:length])


def test_what_is_no_json_is_refused_and_ctrl_c_is_not_taken_for_it(monkeypatch):
    with pytest.raises(DataError, match="a record of the run is not JSON"):
        event_from("{")

    def interrupted(_data):
        raise KeyboardInterrupt

    monkeypatch.setattr(json, "loads", interrupted)
    with pytest.raises(KeyboardInterrupt):
        event_from("{")
