"""`rigrunner upgrade`: what it shows, writes and refuses, and its effect on approvals."""

from __future__ import annotations

import hashlib
import json

import pytest

from helpers_cli import call
from helpers_language import PROCEDURE, only_problem
from rigrunner.procedure import load_procedure, parse_procedure, texts_digest
from rigrunner.run.approval import approval_state

NEW_FORM = "analysis:\n  - swing_torque:\n"
OLD = (
    "rigrunner: procedure/1\nid: OLD\nrevision: 'A'\ntitle: Of before\n"
    "measurand: {symbol: T, name: torque}\nuses: {tester: swing_tester}\n"
    "main: [{settle: {time: 1 s}}]  # no more\nanalysis:\n  fits: [polynomial]\n"
)


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "old.yaml"
    path.write_text(OLD, encoding="utf-8")
    return path


def write_approval(path, digest):
    approval = {"revision": "A", "by": "A. Jones", "utc": "2026-01-31", "sha256": digest}
    content = {"rigrunner": "approval/1", "procedure": "OLD", "approved": approval}
    path.with_suffix(".approval.json").write_text(json.dumps(content), encoding="utf-8")


def test_older_file_is_refused_with_the_upgrade_command(old):
    problem = only_problem(load_procedure, old)

    assert str(problem.location) == f"{old}:1:12"
    assert "expected 'procedure/2'" in problem.message
    command = problem.hint.removeprefix("type 'rigrunner ").removesuffix("'").split()
    assert call(*command).code == 0
    assert load_procedure(old).model.analysis[0].name == "swing_torque"


def test_upgrade_keeps_the_older_text_and_shows_the_difference(old):
    result = call("upgrade", old)

    assert result.code == 0
    assert "+  - swing_torque:\n" in result.out
    assert "-  fits: [polynomial]\n" in result.out
    assert old.with_name("old.yaml.old").read_text() == OLD
    assert old.read_text().endswith("main: [{settle: {time: 1 s}}]  # no more\n" + NEW_FORM
                                    + "      fits: [polynomial]\n")  # fmt: skip


def test_approval_of_the_older_text_does_not_cover_the_upgraded_one(old):
    write_approval(old, texts_digest(OLD, {}))
    result = call("upgrade", old)

    note = "the procedure was changed after its approval by A. Jones on 2026-01-31"
    assert f"OLD, revision A: draft, not for certification: {note}" in result.out
    assert approval_state(load_procedure(old)).is_draft


def test_dry_run_writes_nothing(old):
    result = call("upgrade", "--dry-run", old)

    assert "+  - swing_torque:\n" in result.out
    assert [path.name for path in old.parent.iterdir()] == ["old.yaml"]
    assert old.read_text() == OLD


def test_out_folder_leaves_the_original_file_unchanged(old, tmp_path):
    assert call("upgrade", old, "--out", tmp_path / "new").code == 0

    assert old.read_text() == OLD
    assert NEW_FORM in (tmp_path / "new" / "old.yaml").read_text()


@pytest.mark.parametrize("out", [False, True])
def test_nothing_is_overwritten(old, tmp_path, out):
    second = tmp_path / "other.yaml"
    second.write_text(OLD, encoding="utf-8")
    existing = tmp_path / "other.yaml" if out else tmp_path / "other.yaml.old"
    existing.write_text(OLD, encoding="utf-8")
    result = call("upgrade", old, second, *(["--out", tmp_path] if out else []))

    assert result.code == 2
    assert f"there is a file {tmp_path}" in result.err
    assert old.read_text() == second.read_text() == existing.read_text() == OLD


def test_two_files_with_the_same_name_are_refused(old, tmp_path):
    second = tmp_path / "elsewhere" / "old.yaml"
    second.parent.mkdir()
    second.write_text(OLD, encoding="utf-8")
    result = call("upgrade", old, second, "--out", tmp_path / "new")

    assert result.code == 2
    assert f"two of the files would be written to {tmp_path / 'new' / 'old.yaml'}" in result.err
    assert not (tmp_path / "new").exists()


def test_current_file_needs_no_upgrade(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(PROCEDURE, encoding="utf-8")

    assert "needs no upgrade" in call("upgrade", path).err
    assert path.read_text() == PROCEDURE


def test_stored_older_text_is_read_and_keeps_its_digest():
    loaded = parse_procedure(OLD, "a run", stored=True)

    (analysis,) = loaded.model.analysis
    assert (analysis.name, analysis.settings["fits"]) == ("swing_torque", ["polynomial"])
    assert loaded.text == OLD
    assert loaded.digest == hashlib.sha256(OLD.encode()).hexdigest()
