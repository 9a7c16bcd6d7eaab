"""A member equals its text, and keeps its parts through copies and validation."""

import copy
import json
import pickle

import pytest
from pydantic import TypeAdapter, ValidationError
from pydantic_core import to_json

from rigrunner.api.member import Member, role_of

TORQUE = Member("tester", "torque")


def test_member_equals_its_text():
    assert str(TORQUE) == "tester.torque"
    assert {TORQUE: 1.0} == {"tester.torque": 1.0}
    assert json.dumps({TORQUE: TORQUE}) == '{"tester.torque": "tester.torque"}'
    assert to_json({TORQUE: [TORQUE]}) == b'{"tester.torque":["tester.torque"]}'


@pytest.mark.parametrize(
    "copy_of",
    [
        copy.copy, copy.deepcopy, Member.parse,
        lambda member: pickle.loads(pickle.dumps(member)),  # noqa: S301  (its own)
        lambda member: Member.parse(str(member)),
        lambda member: TypeAdapter(Member).validate_python(str(member), strict=True),
        lambda member: TypeAdapter(dict[Member, int]).validate_python({member: 1}).popitem()[0],
    ],
)  # fmt: skip
def test_member_keeps_its_parts(copy_of):
    member = copy_of(TORQUE)
    assert (member, member.role, member.name) == ("tester.torque", "tester", "torque")


@pytest.mark.parametrize(
    "text", ["torque", "tester.", ".torque", "a.b.c", "1st.torque", "tester. torque", "tester.ü"]
)
def test_invalid_text_is_refused(text):
    with pytest.raises(ValueError, match=r"is not of the form role\.name, such as tester\.torque"):
        Member.parse(text)
    with pytest.raises(ValidationError):
        TypeAdapter(Member).validate_python(text)


def test_role_of_a_member_or_a_device():
    assert role_of(TORQUE) == role_of("tester") == "tester"
