"""Reasons to refuse a certificate although its content is complete."""

from __future__ import annotations

from datetime import UTC, datetime
from types import SimpleNamespace

import pytest

from helpers_certificate import issue, make_letterhead
from rigrunner.api.errors import UsageError
from rigrunner.certificate.numbers import Numbers
from rigrunner.certificate.withdrawal import Withdrawal
from rigrunner.documents.certifying.certify import _further_copy, _refuse_early_issue

SOURCE = SimpleNamespace(
    stored=SimpleNamespace(header=SimpleNamespace(run_id="r")),
    result=SimpleNamespace(run=SimpleNamespace(ended_utc="2026-11-22T05:08:38.000Z")),
)


def request(folder, reason=""):
    by = SimpleNamespace(by="A")
    return SimpleNamespace(letterhead=folder, further_copy=reason, authorisation=by)


def test_certificate_cannot_be_issued_before_the_end_of_its_run():
    _refuse_early_issue(SOURCE, datetime(2026, 11, 22, 5, 9, tzinfo=UTC))
    with pytest.raises(
        UsageError, match=r"ended on 2026-11-22T05:08:38, and it is 2026-11-22T05:0"
    ):
        _refuse_early_issue(SOURCE, datetime(2026, 11, 22, 5, 8, tzinfo=UTC))


def test_second_certificate_on_a_run_must_be_an_amendment(tmp_path):
    letterhead, further_request = SimpleNamespace(prefix="RR"), request(tmp_path)
    assert _further_copy(SOURCE, letterhead, further_request, is_specimen=False) is None
    numbers = Numbers(tmp_path, "RR")
    numbers.issued(numbers.reserve(2026, {"run": "r"}), {})
    for reason in ("", "in German"):
        with pytest.raises(UsageError, match="RR-2026-0001 was already issued on r") as caught:
            _further_copy(SOURCE, letterhead, request(tmp_path, reason), is_specimen=False)
        assert "rigrunner amend" in caught.value.hint


@pytest.mark.parametrize("is_specimen", [True, False])
def test_run_whose_certificate_was_withdrawn_is_certified_by_an_amendment(tmp_path, is_specimen):
    """The new document must name what it replaces (ISO/IEC 17025, 7.8.8.3)."""
    letterhead = SimpleNamespace(prefix="RR")
    numbers = Numbers.of(tmp_path, letterhead, is_specimen=is_specimen)
    number = numbers.reserve(2026, {"run": "r"})
    numbers.issued(number, {})
    numbers.withdraw(
        Withdrawal(number=number, sha256="", by="B", utc="2026-11-22T09:30:00Z", reason="wrong")
    )
    for reason in ("", "in German"):
        with pytest.raises(UsageError) as caught:
            _further_copy(SOURCE, letterhead, request(tmp_path, reason), is_specimen=is_specimen)
        assert caught.value.message == (
            f"{number} was issued on r, and withdrawn by B on 2026-11-22: wrong"
        )
        assert f"'rigrunner amend' replaces {number}" in caught.value.hint


def test_further_specimen_certificate_needs_a_reason(tmp_path):
    letterhead = SimpleNamespace(prefix="RR")
    numbers = Numbers(tmp_path, "SPECIMEN-RR")
    with pytest.raises(UsageError, match="nothing was issued on r yet"):
        _further_copy(SOURCE, letterhead, request(tmp_path, "in German"), is_specimen=True)
    numbers.issued(numbers.reserve(2026, {"run": "r"}), {})
    with pytest.raises(UsageError, match="SPECIMEN-RR-2026-0001 exists") as caught:
        _further_copy(SOURCE, letterhead, request(tmp_path, "  "), is_specimen=True)
    assert "amend it" in caught.value.hint
    assert "a further copy, with a reason" in caught.value.hint
    copy = _further_copy(SOURCE, letterhead, request(tmp_path, "in German"), is_specimen=True)
    assert (copy.number, copy.reason, copy.by) == ("SPECIMEN-RR-2026-0001", "in German", "A")


@pytest.mark.usefixtures("tester")
def test_simulated_run_is_never_certified(tester_runs, tmp_path):
    letterhead = make_letterhead(tmp_path / "letterhead")
    with pytest.raises(UsageError, match="its data are simulated") as caught:
        issue(tester_runs.loaded, letterhead, tmp_path / "out", not_for_certification=False)
    assert caught.value.field == "not_for_certification"
    assert not (tmp_path / "out").exists()
    assert not (letterhead / "numbers").exists()
