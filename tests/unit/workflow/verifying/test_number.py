"""With the laboratory's folder, a reader learns whether a document is the one on record."""

from __future__ import annotations

import hashlib

import pytest

from rigrunner.certificate.numbers import Numbers
from rigrunner.workflow.verifying.number import check_number
from rigrunner.workflow.verifying.verification import Verification

NUMBER = "SPECIMEN-DEMO-2026-0001"


@pytest.fixture
def issued(tmp_path):
    """Return a document that is on record, and the laboratory's numbers."""
    form = tmp_path / f"{NUMBER}.json"
    form.write_bytes(b"content")
    numbers = Numbers(tmp_path, "SPECIMEN-DEMO")
    assert numbers.reserve(2026, {"run": "r"}) == NUMBER
    sha256 = hashlib.sha256(b"content").hexdigest()
    numbers.issued(NUMBER, {"sha256": {form.name: sha256}})
    return form, numbers


def checked(form, folder, number=NUMBER):
    found = Verification()
    check_number(found, [form], number, folder)
    return found


def test_a_document_as_it_was_issued(issued, tmp_path):
    found = checked(issued[0], tmp_path)
    assert (found.held, found.differences, found.information) == (
        *([f"record of {NUMBER}"], [], []),
    )


def test_one_that_was_replaced_is_told_and_still_matches(issued, tmp_path):
    form, numbers = issued
    numbers.issued(numbers.reserve(2026, {"run": "r", "amends": NUMBER}), {})
    found = checked(form, tmp_path)
    assert found.matches
    assert found.information == [
        f"{NUMBER} is no longer in force: SPECIMEN-DEMO-2026-0002 replaced it"
    ]


def test_one_that_was_changed_and_sealed_anew_differs(issued, tmp_path):
    issued[0].write_bytes(b"other content")
    assert checked(issued[0], tmp_path).differences == [
        f"record of {NUMBER}: {NUMBER}.json is not as it was issued"
    ]


def test_a_number_that_was_never_given_differs(issued, tmp_path):
    found = checked(issued[0], tmp_path, "SPECIMEN-DEMO-2026-0007")
    assert "it was not issued under the letterhead" in found.differences[0]


def test_a_copy_of_the_letterhead_without_its_numbers_says_nothing(issued, tmp_path):
    found = checked(issued[0], tmp_path / "copy")
    assert (found.held, found.differences) == ([], [])
    assert found.information == [
        f"{tmp_path / 'copy'} keeps no numbers: the record was not looked at"
    ]
