from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.proof.compare import _words, mismatches

ESTIMATE = {"value": 0.72731572, "expanded_uncertainty_95": 0.0093946, "unit": "N·m"}


def differences(recorded, derived):
    return [str(mismatch) for mismatch in mismatches(recorded, derived)]


@pytest.mark.parametrize(
    ("change", "same"),
    [
        ({"value": 0.72731572 + 4e-5}, True),  # printed as 0.7273: the place is 1e-4
        ({"value": 0.72731572 - 4e-5}, True),
        ({"value": 0.72731572 + 6e-5}, False),
        ({"expanded_uncertainty_95": 0.0093948}, True),
        ({"expanded_uncertainty_95": 0.00941}, False),
        ({"unit": "mN·m"}, False),
        ({"value": None}, False),
        ({"value": float("nan")}, False),
        ({"value": "0.7273"}, False),
    ],
)
def test_estimates_are_compared_at_their_printed_digits(change, same):
    assert (differences(ESTIMATE, ESTIMATE | change) == []) is same


@pytest.mark.parametrize("member", ["value", "expanded_uncertainty_95"])
def test_small_number_with_known_resolution_is_not_zero(member):
    picoamperes = {"value": 5e-13, "expanded_uncertainty_95": 2e-14, "unit": "A"}
    assert differences(picoamperes, picoamperes | {member: 2 * picoamperes[member]})
    assert differences(picoamperes, picoamperes | {member: picoamperes[member] * (1 + 1e-9)}) == []


@pytest.mark.parametrize(
    ("recorded", "derived", "same"),
    [
        (1234.0, 1234.05, True),
        (1234.0, 1234.2, False),
        (0.0, 1e-13, True),
        (0.0, 1e-11, False),
        ([10.0, 1e-9], [10.0, -1e-9], True),  # noise beside what the array holds
        ([[1.0, 1e-9], [1e-9, 1.0]], [[1.0, 2e-9], [1e-9, 1.0]], True),
        ([10.0, 1.0], [10.0, 1.01], False),
        ([1.0], [1.0, 1.0], False),
        (True, 1.0, False),
        (True, True, True),
        (None, None, True),
        (12, 12.0, True),
        ("pass", "fail", False),
        ("0.7273 N·m is 0.2227 N·m within", "0.7274 N·m is 0.2226 N·m within", True),
        ("0.7273 N·m", "0.7275 N·m", False),
        ("0.7273 N·m", "0.7273 N·mm", False),
        ("cycle 12 of 30", "cycle 13 of 30", False),
        ("SN-17", "SN-18", False),
        ("0.99", "0.990", False),
    ],
)
def test_values_are_compared_as_printed(recorded, derived, same):
    assert (differences(recorded, derived) == []) is same


def test_difference_is_located_by_readable_path():
    recorded = {"points": [{"recording": "001_5Hz", "load": {"value": 1000.0, "unit": "N"}}]}
    derived = json.loads(json.dumps(recorded).replace("1000.0", "1010.0"))
    assert differences(recorded, derived) == [
        "points/001_5Hz/load/value: 1000 is recorded, 1010 was derived"
    ]


@pytest.mark.parametrize("derived", [None, 1.0, {"a": 1}])
def test_list_differs_from_what_is_no_list(derived):
    (difference,) = differences({"values": [1.0]}, {"values": derived})
    assert difference == f"values: [1.0] is recorded, {_words(derived)} was derived"


def test_missing_members_are_reported_and_newer_ones_are_not():
    assert differences({"a": 1}, {}) == ["a: 1 is recorded, and was not derived"]
    assert differences({}, {"a": 1}) == []


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(JSON)
def test_document_equals_itself(document):
    assert differences(document, document) == []


CLIPPING = {"name": "clipping", "ok": True, "text": "nowhere", "value": 1.0}
ZERO = {"name": "zero", "ok": True, "text": "was zeroed", "value": 0.0}


@pytest.mark.parametrize(
    ("recorded", "derived", "expected"),
    [
        ([CLIPPING], [ZERO, CLIPPING], []),
        ([], [CLIPPING], []),
        ([CLIPPING, ZERO], [CLIPPING], ["checks/zero: the check is recorded, and was not derived"]),
        (
            [ZERO],
            [CLIPPING | {"ok": False, "text": "9 equal samples"}, ZERO],
            ["checks/clipping: the check fails, and is not recorded: 9 equal samples"],
        ),
        (
            [CLIPPING],
            [CLIPPING | {"ok": False}],
            ["checks/clipping/ok: True is recorded, False was derived"],
        ),
    ],
)
def test_checks_of_a_newer_program_differ_only_if_they_fail(recorded, derived, expected):
    assert differences({"checks": recorded}, {"checks": derived}) == expected


def named_result(name, value):
    return {"name": name, "coordinates": {}, "estimate": {"value": value, "unit": "V"}}


def test_results_with_an_unrecorded_name_are_ignored():
    recorded = [named_result("range", 1.0)]
    assert differences(recorded, [named_result("torque", 2.0), named_result("range", 1.0)]) == []
    assert differences(recorded, [named_result("torque", 2.0)]) != []
    assert differences(recorded, [named_result("range", 1.0), named_result("range", 2.0)]) != []


def test_older_limit_matches_with_more_digits():
    """A limit of 1 lbf·in, 0.112984829 N·m, was written with six digits."""
    older = {"limit": "≤ 0.112985 N·m"}
    assert not list(mismatches(older, {"limit": "≤ 0.11298482902 N·m"}))
    assert list(mismatches(older, {"limit": "≤ 0.11298682902 N·m"}))
    assert list(mismatches({"limit": "≤ 0.1129 N·m"}, {"limit": "≤ 0.11298482902 N·m"}))
