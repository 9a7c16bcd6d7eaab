"""The check of a document against the records of the laboratory."""

from __future__ import annotations

import hashlib

import pytest

from rigrunner.api.certificate import Certificate
from rigrunner.api.errors import ExitCode
from rigrunner.certificate.numbers import Numbers
from rigrunner.certificate.withdrawal import Withdrawal
from rigrunner.documents.verifying.document import check_name, check_number
from rigrunner.documents.verifying.forms import Form
from rigrunner.documents.verifying.verification import Verification

NUMBER = "SPECIMEN-DEMO-2026-0001"


@pytest.fixture
def issued(tmp_path):
    """Return a document on record, and the numbers of the laboratory."""
    form = tmp_path / f"{NUMBER}.json"
    form.write_bytes(b"content")
    numbers = Numbers(tmp_path, "SPECIMEN-DEMO")
    assert numbers.reserve(2026, {"run": "r"}) == NUMBER
    sha256 = hashlib.sha256(b"content").hexdigest()
    numbers.issued(NUMBER, {"sha256": {form.name: sha256}})
    return form, numbers


def verification_of(form, folder, number=NUMBER):
    verification = Verification()
    forms = [Form(form, form.read_bytes())]
    check_number(verification, forms, Certificate.model_construct(number=number), folder)
    return verification


def test_issued_document_matches_its_record(issued, tmp_path):
    verification = verification_of(issued[0], tmp_path)
    assert (verification.held, verification.differences, verification.information) == (
        *([f"record of {NUMBER}"], [], []),
    )


def test_replaced_document_never_matches(issued, tmp_path):
    form, numbers = issued
    numbers.issued(numbers.reserve(2026, {"run": "r", "amends": NUMBER}), {})
    verification = verification_of(form, tmp_path)
    assert not verification.matches
    assert verification.exit_code is ExitCode.REPLACED
    assert verification.conclusion == (
        f"REPLACED: {NUMBER} is no longer in force: SPECIMEN-DEMO-2026-0002 replaced it"
    )


def withdrawal(sha256=""):
    return Withdrawal(
        number=NUMBER, sha256=sha256, by="A. Nother", utc="2026-11-30T09:30:00.000Z", reason="a\nb"
    )


def test_withdrawn_document_never_matches(issued, tmp_path):
    form, numbers = issued
    numbers.withdraw(withdrawal())
    verification = verification_of(form, tmp_path)
    assert verification.exit_code is ExitCode.WITHDRAWN
    assert verification.conclusion == (
        f"WITHDRAWN: {NUMBER} is no longer in force: withdrawn by A. Nother on 2026-11-30: a b"
    )
    assert verification.held == [f"record of {NUMBER}"]


def test_withdrawn_and_replaced_document_is_both(issued, tmp_path):
    form, numbers = issued
    numbers.withdraw(withdrawal())
    numbers.issued(numbers.reserve(2026, {"run": "r", "amends": NUMBER}), {})
    verification = verification_of(form, tmp_path)
    assert verification.exit_code is ExitCode.WITHDRAWN
    assert verification.replaced == [
        f"{NUMBER} is no longer in force: SPECIMEN-DEMO-2026-0002 replaced it"
    ]


@pytest.mark.parametrize(
    ("sha256", "is_of_this_document"),
    [(hashlib.sha256(b"content").hexdigest(), True), ("", True), ("ab" * 32, False)],
)
@pytest.mark.parametrize("folder", ["", "copy"])
def test_notice_beside_withdraws_only_its_document(
    issued, tmp_path, folder, sha256, is_of_this_document
):
    """Another laboratory may have issued the same number. The record need not say so too."""
    notice = tmp_path / f"{NUMBER}.withdrawn.json"
    notice.write_text(withdrawal(sha256).model_dump_json(), encoding="utf-8")
    text = (
        f"{NUMBER} is no longer in force, as {notice.name} beside it says: withdrawn by A. Nother"
        " on 2026-11-30: a b"
    )
    withdrawn = verification_of(issued[0], tmp_path / folder).withdrawn
    assert withdrawn == [text] * is_of_this_document


@pytest.mark.parametrize("content", [b"", b"{}", b"[" * 100_000, b"\xff", b'{"number": 7}'])
@pytest.mark.parametrize("folder", ["", "numbers"])
def test_damaged_withdrawal_still_withdraws(issued, tmp_path, folder, content):
    (tmp_path / folder / f"{NUMBER}.withdrawn.json").write_bytes(content)
    (text,) = verification_of(issued[0], tmp_path).withdrawn
    assert text.startswith(f"{NUMBER} is no longer in force")
    assert text.endswith("withdrawn, but the record of it cannot be read")


@pytest.mark.parametrize("number", ["S/../../x", "a\0b", "n" * 5000])
def test_number_that_is_no_file_name_is_not_withdrawn(issued, tmp_path, number):
    assert verification_of(issued[0], tmp_path, number).withdrawn == []


@pytest.mark.parametrize(
    "name", [NUMBER, f"{NUMBER} (1)", f"signed-{NUMBER}", "certificate of the bearing"]
)
def test_file_may_have_the_name_of_its_document_or_of_none(name, tmp_path):
    verification = Verification()
    check_name(verification, tmp_path / f"{name}.pdf", NUMBER)
    assert verification.differences == []
    assert bool(verification.information) == (name != NUMBER)


@pytest.mark.parametrize("name", ["SPECIMEN-DEMO-2026-0002", "DEMO-2026-0001", "DEMO-2025-00010 x"])
def test_name_of_another_document_is_a_difference(name, tmp_path):
    verification = Verification()
    check_name(verification, tmp_path / f"{name}.pdf", NUMBER)
    (difference,) = verification.differences
    assert f"the document in it is {NUMBER}, not {name.split()[0]}" in difference


def test_changed_and_resealed_document_is_a_difference(issued, tmp_path):
    issued[0].write_bytes(b"other content")
    assert verification_of(issued[0], tmp_path).differences == [
        f"record of {NUMBER}: {NUMBER}.json is not as it was issued"
    ]


def test_unknown_number_is_a_difference(issued, tmp_path):
    verification = verification_of(issued[0], tmp_path, "SPECIMEN-DEMO-2026-0007")
    assert "it was not issued under the letterhead" in verification.differences[0]


def test_letterhead_without_numbers_is_only_reported(issued, tmp_path):
    verification = verification_of(issued[0], tmp_path / "copy")
    assert (verification.held, verification.differences) == ([], [])
    assert verification.information == [
        f"{tmp_path / 'copy'} has no record of numbers, so it was not checked"
    ]
