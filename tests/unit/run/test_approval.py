"""Approvals: bound to the texts, revoked by an edit, kept in a file that may be invalid."""

from __future__ import annotations

import hashlib
import json
from datetime import UTC, date, datetime

import pytest

from helpers_language import problems_of
from helpers_tester import procedure_file, run
from rigrunner.api.errors import UsageError
from rigrunner.procedure import load_procedure, texts_digest
from rigrunner.run.approval import approval_file, approval_state, approve, moment_of
from rigrunner.run.locate import find_procedure
from rigrunner.runfile import read

WHEN = "2026-02-03T10:00:00.000Z"
CALLER = """\
rigrunner: procedure/2
id: OUTER
revision: "2"
title: Calls another one
measurand: {symbol: T, name: temperature}
uses: {room: thermometer}
main:
  - call: {procedure: parts/inner.yaml}
"""
CALLED = """\
rigrunner: procedure/2
id: INNER
revision: "1"
title: Is called
measurand: {symbol: T, name: temperature}
uses: {room: thermometer}
main:
  - measure: {channels: [room.temperature]}
"""


@pytest.fixture
def outer(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "inner.yaml").write_text(CALLED, encoding="utf-8")
    path = tmp_path / "outer.yaml"
    path.write_text(CALLER, encoding="utf-8")
    return path


def state(path):
    return approval_state(load_procedure(path))


def test_procedure_is_a_draft_until_approved(outer):
    assert state(outer).is_draft
    assert state(outer).sentence() == "draft, not for certification"

    approve(load_procedure(outer), " A. Jones ", WHEN)
    approval = state(outer)
    assert (approval.state, approval.by, approval.utc) == ("approved", "A. Jones", WHEN)
    assert approval.sentence() == "approved by A. Jones on 2026-02-03"


def test_digest_can_be_computed_with_other_programs(outer):
    outer_digest, inner = (hashlib.sha256(text.encode()).hexdigest() for text in (CALLER, CALLED))
    listing = f"{outer_digest}  procedure\n{inner}  parts/inner.yaml\n"

    assert state(outer).sha256 == hashlib.sha256(listing.encode()).hexdigest()


def test_digest_depends_on_which_file_has_which_text():
    assert texts_digest("a", {"b": "x", "c": "y"}) != texts_digest("a", {"b": "y", "c": "x"})
    assert texts_digest("a", {"b": "x", "c": "y"}) == texts_digest("a", {"c": "y", "b": "x"})


@pytest.mark.parametrize("file", ["outer.yaml", "parts/inner.yaml"])
def test_edit_revokes_approval_and_names_approver(outer, file):
    approve(load_procedure(outer), "A. Jones", WHEN)
    edited = outer.parent / file
    edited.write_text(f"{edited.read_text(encoding='utf-8')}# a comment\n", encoding="utf-8")

    assert state(outer).is_draft
    assert state(outer).by == ""
    assert "was changed after its approval by A. Jones on 2026-02-03" in state(outer).note


def test_undoing_the_edit_restores_approval(outer):
    approve(load_procedure(outer), "A. Jones", WHEN)
    outer.write_text(f"{CALLER}# a comment\n", encoding="utf-8")
    outer.write_text(CALLER, encoding="utf-8")
    assert state(outer).state == "approved"


def test_approval_of_another_procedure_is_ignored(outer):
    path = approve(load_procedure(outer), "A. Jones", WHEN)
    path.write_text(path.read_text(encoding="utf-8").replace("OUTER", "OTHER"), encoding="utf-8")
    assert state(outer).is_draft


def test_earlier_approvals_are_kept(outer):
    for name in ("A. Jones", "B. Lee", "C. Roy"):
        approve(load_procedure(outer), name, WHEN)
    content = json.loads(approval_file(outer).read_text(encoding="utf-8"))
    assert content["approved"]["by"] == "C. Roy"
    assert [approval["by"] for approval in content["earlier"]] == ["A. Jones", "B. Lee"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not YAML"),
        ("[]", "expected a mapping"),
        ('{"rigrunner": "approval/1"}', "'procedure' is missing"),
        ('{"rigrunner": "approval/2"}', "expected 'approval/1'"),
        ("", "the file is empty"),
    ],
)
def test_invalid_approval_file_is_reported_with_its_place(outer, text, message):
    approval_file(outer).write_text(text, encoding="utf-8")
    problems = problems_of(approval_state, load_procedure(outer))
    assert any(message in problem.message for problem in problems)
    assert {problem.location.file for problem in problems} == {str(approval_file(outer))}


def test_approval_needs_a_name(outer):
    with pytest.raises(UsageError, match="needs a name"):
        approve(load_procedure(outer), "  ", WHEN)


def test_shipped_procedure_is_a_draft_and_cannot_be_approved():
    shipped = load_procedure(find_procedure("resistance_over_temperature"))
    assert approval_state(shipped).is_draft
    with pytest.raises(UsageError, match="a laboratory approves a copy of its own"):
        approve(shipped, "A. Jones", WHEN)


def test_approval_date_must_not_be_in_the_future():
    now = datetime(2026, 2, 3, 23, 30, tzinfo=UTC)
    assert moment_of(None, now) == "2026-02-03T23:30:00.000Z"
    assert moment_of(date(2026, 2, 3), now) == "2026-02-03"
    with pytest.raises(UsageError, match="in the future"):
        moment_of(date(2026, 2, 4), now)


@pytest.mark.usefixtures("tester")
def test_run_stores_approval_state_of_its_procedure(tmp_path):
    path = procedure_file(tmp_path, "idle")
    draft = run(path, tmp_path / "runs")
    approve(load_procedure(path), "A. Jones", WHEN)
    approved = run(path, tmp_path / "runs")

    digest = texts_digest(path.read_text(encoding="utf-8"), {})
    assert read(draft.folder).header.approval == {"state": "draft", "sha256": digest}
    assert read(approved.folder).header.approval == {
        "state": "approved",
        "by": "A. Jones",
        "utc": WHEN,
        "sha256": digest,
    }
    assert read(approved.folder).header.people == {"operator": "Demo operator"}
    reports = [run.report.read_text(encoding="utf-8") for run in (draft, approved)]
    assert ["Not for certification" in report for report in reports] == [True, False]
    assert "approved by A. Jones on 2026-02-03" in reports[1]
