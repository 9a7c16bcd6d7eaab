"""A certificate is withdrawn once, by name and with a reason, and for good."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest

from rigrunner.api.certificate import Authorisation, parse_certificate
from rigrunner.api.errors import DataError, UsageError
from rigrunner.documents.certifying.amend import AmendRequest, amend
from rigrunner.documents.certifying.withdraw import withdraw
from rigrunner.registry import Registry

OLD = Path(__file__).parents[3] / "data" / "0.1.0"
REPLACED, NUMBER = "SPECIMEN-DEMO-2026-0001", "SPECIMEN-DEMO-2026-0002"
NOW = datetime(2026, 11, 30, 9, 30, tzinfo=UTC)
WITHDRAWN = "withdrawn by Z. Head on 2026-11-30: the wrong item"


@pytest.fixture
def lab(tmp_path):
    """Return a folder with a letterhead and its certificates, of which the second is in force."""
    for name in ("letterhead", "certificates"):
        shutil.copytree(OLD / name, tmp_path / name)
    return tmp_path


def withdrawn(lab, number=NUMBER, by="Z. Head", reason="the wrong item", suffix=".json"):
    path = lab / "certificates" / f"{number}{suffix}"
    return withdraw(path, lab / "letterhead", by=by, reason=reason, now=NOW)


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("suffix", [".json", ".pdf"])
def test_record_and_notice_state_who_when_and_why(lab, suffix):
    before = contents(lab)
    notice = withdrawn(lab, by=" Z. Head ", reason="the wrong item\n", suffix=suffix)
    record = lab / "letterhead/numbers" / f"{NUMBER}.withdrawn.json"
    assert notice == lab / "certificates" / record.name
    assert notice.read_bytes() == record.read_bytes()
    issued = json.loads(record.with_name(f"{NUMBER}.issued.json").read_bytes())
    assert json.loads(record.read_bytes()) == {
        "rigrunner": "withdrawal/1",
        "number": NUMBER,
        "sha256": issued["sha256"][f"{NUMBER}.json"],
        "by": "Z. Head",
        "utc": "2026-11-30T09:30:00.000Z",
        "reason": "the wrong item",
    }
    assert {path: content for path, content in contents(lab).items() if path in before} == before


@pytest.mark.parametrize(
    ("changes", "message", "field"),
    [
        ({"reason": " \n"}, "a withdrawal needs its --reason", "reason"),
        ({"by": " "}, "a withdrawal needs the name of the person who withdraws", "by"),
        ({"number": "SPECIMEN-DEMO-2026-0009"}, "there is no .*0009.json", ""),
        ({"number": REPLACED}, f"{REPLACED} was already replaced by {NUMBER}", ""),
    ],
)
def test_refused_withdrawal_leaves_no_trace(lab, changes, message, field):
    before = contents(lab)
    with pytest.raises(UsageError, match=message) as caught:
        withdrawn(lab, **changes)
    assert caught.value.field == field
    assert contents(lab) == before


def test_certificate_of_another_laboratory_is_not_withdrawn(lab):
    shutil.rmtree(lab / "letterhead/numbers")
    with pytest.raises(UsageError, match=f"{NUMBER} was not issued under the letterhead in"):
        withdrawn(lab)


def test_changed_certificate_is_not_withdrawn(lab):
    path = lab / "certificates" / f"{NUMBER}.json"
    path.write_bytes(path.read_bytes() + b" ")
    with pytest.raises(DataError, match=f"{NUMBER} has changed since it was issued"):
        withdrawn(lab)


def test_second_withdrawal_is_refused_and_names_the_first(lab):
    notice = withdrawn(lab)
    before = contents(lab)
    with pytest.raises(UsageError, match=f"{NUMBER} was already {WITHDRAWN}"):
        withdrawn(lab, by="Another", reason="another")
    notice.unlink()  # its removal does not undo the withdrawal
    with pytest.raises(UsageError, match=f"{NUMBER} was already {WITHDRAWN}"):
        withdrawn(lab, by="Another", reason="another")
    assert contents(lab) | {notice: before[notice]} == before


def test_in_a_read_only_letterhead_nothing_is_withdrawn(lab, monkeypatch):
    before, opened = contents(lab), Path.open

    def read_only(self, mode="r", **options):
        if "x" in mode:  # also for root, whom no permission stops
            raise PermissionError(13, "Permission denied", str(self))
        return opened(self, mode, **options)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "open", read_only)
        with pytest.raises(DataError, match=r"cannot keep the number in .*: Permission denied"):
            withdrawn(lab)
    assert contents(lab) == before


def test_record_holds_where_the_notice_cannot_be_written(lab):
    notice = lab / "certificates" / f"{NUMBER}.withdrawn.json"
    notice.mkdir()
    with pytest.raises(DataError, match=f"{NUMBER} is withdrawn, but .* cannot be written") as hit:
        withdrawn(lab)
    record = lab / "letterhead/numbers" / notice.name
    assert hit.value.hint == f"copy {record} there"
    assert record.is_file()


def test_replacement_of_a_withdrawn_certificate_states_the_withdrawal(lab):
    withdrawn(lab)
    request = AmendRequest(
        letterhead=lab / "letterhead",
        reason="tested again",
        authorisation=Authorisation(by="B"),
        changes={"item_id": "42"},
    )
    path = lab / "certificates" / f"{NUMBER}.json"
    before = parse_certificate(path.read_bytes(), path.name).item.identification
    amends = amend(path, request, Registry([]), NOW).certificate.amends
    assert [(each.field, each.before, each.after) for each in amends.changes] == [
        ("withdrawal", WITHDRAWN, ""),
        ("item.identification", before, "42"),
    ]
