"""What keeps a certificate from being issued though everything is there."""

from __future__ import annotations

from datetime import UTC, datetime
from types import SimpleNamespace

import pytest

from rigrunner.api.errors import UsageError
from rigrunner.certificate.numbers import Numbers
from rigrunner.workflow.certifying.certify import _refuse_early_issue, _refuse_second

SOURCE = SimpleNamespace(
    stored=SimpleNamespace(header=SimpleNamespace(run_id="r")),
    result=SimpleNamespace(run=SimpleNamespace(ended_utc="2026-11-22T05:08:38.000Z")),
)


def test_a_certificate_is_not_dated_before_its_test():
    _refuse_early_issue(SOURCE, datetime(2026, 11, 22, 5, 9, tzinfo=UTC))
    with pytest.raises(
        UsageError, match=r"ended on 2026-11-22T05:08:38, and it is 2026-11-22T05:0"
    ):
        _refuse_early_issue(SOURCE, datetime(2026, 11, 22, 5, 8, tzinfo=UTC))


def test_a_second_certificate_on_a_run_must_name_what_it_replaces(tmp_path):
    letterhead = SimpleNamespace(prefix="RR")
    _refuse_second(SOURCE, letterhead, tmp_path)
    numbers = Numbers(tmp_path, "RR")
    numbers.issued(numbers.reserve(2026, {"run": "r"}), {})
    with pytest.raises(UsageError, match="RR-2026-0001 was issued on r already") as caught:
        _refuse_second(SOURCE, letterhead, tmp_path)
    assert "rigrunner amend" in caught.value.hint
