"""The fate of each certificate number is on record, even if no file could be written."""

from __future__ import annotations

import json

import pytest

from helpers_certificate import NOW, issue, make_letterhead, without_pdf
from rigrunner.api.errors import DataError
from rigrunner.certificate.numbers import Numbers
from rigrunner.documents.certifying.office import MAKING


@pytest.fixture
def lab(tmp_path):
    return make_letterhead(tmp_path / "letterhead")


def test_digests_of_the_issued_files_are_recorded_with_the_number(quick, lab, tmp_path):
    issued = issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert [path.suffix for path in issued.files] == [".json", ".html"]
    number = issued.certificate.number
    record = json.loads((lab / "numbers" / f"{number}.issued.json").read_text(encoding="utf-8"))
    assert set(record["sha256"]) == {path.name for path in issued.files}


@pytest.mark.thorough
def test_number_is_void_if_the_files_cannot_be_written(quick, lab, tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(DataError, match="the certificate cannot be written"):
        issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    void = json.loads((lab / "numbers" / "SPECIMEN-DEMO-2026-0001.void.json").read_text("utf-8"))
    assert "cannot be written" in void["reason"]
    issued = issue(quick.loaded, lab, tmp_path / "other", registry=without_pdf())
    assert issued.certificate.number == "SPECIMEN-DEMO-2026-0002"
    assert issued.notes == ()


def test_number_reserved_before_a_crash_is_noted_at_the_next_issue(quick, lab, tmp_path):
    (lab / "numbers").mkdir()
    (lab / "numbers" / "SPECIMEN-DEMO-2026-0001.json").write_text("")
    issued = issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert issued.certificate.number == "SPECIMEN-DEMO-2026-0002"
    assert issued.notes == ("SPECIMEN-DEMO-2026-0001 was reserved, but not issued",)


def test_files_are_remade_if_another_process_takes_the_number(quick, lab, tmp_path):
    numbers, makings = Numbers(lab, "SPECIMEN-DEMO"), []

    def progress(what, done, of):
        if what == MAKING:
            makings.append((done, of))
        if makings == [(1, 1)]:
            numbers.reserve(NOW.year, {"by": "another process"})

    issued = issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf(), progress=progress)
    assert makings == [(1, 1)] * 2
    assert issued.certificate.number == "SPECIMEN-DEMO-2026-0002"
    for path in issued.files:
        assert path.stem == "SPECIMEN-DEMO-2026-0002"
        assert "SPECIMEN-DEMO-2026-0002" in path.read_text("utf-8")
        assert "SPECIMEN-DEMO-2026-0001" not in path.read_text("utf-8")


def test_failed_form_reserves_no_number(quick, lab, tmp_path, monkeypatch):
    def fail(*_args):
        raise DataError("no form")

    monkeypatch.setattr("rigrunner.documents.certifying.office.CertificateInput", fail)
    with pytest.raises(DataError, match="no form"):
        issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert not (lab / "numbers").exists()


def test_existing_file_is_not_overwritten(quick, lab, tmp_path):
    mine = tmp_path / "out" / "SPECIMEN-DEMO-2026-0001.html"
    mine.parent.mkdir()
    mine.write_text("mine")
    with pytest.raises(DataError, match="File exists"):
        issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert mine.read_text() == "mine"
