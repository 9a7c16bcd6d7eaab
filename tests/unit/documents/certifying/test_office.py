"""What became of a number is on record, also where nothing could be written."""

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


def test_the_digests_of_what_was_issued_stand_with_the_number(quick, lab, tmp_path):
    issued = issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert [path.suffix for path in issued.files] == [".json", ".html"]
    number = issued.certificate.number
    record = json.loads((lab / "numbers" / f"{number}.issued.json").read_text(encoding="utf-8"))
    assert set(record["sha256"]) == {path.name for path in issued.files}


@pytest.mark.thorough
def test_a_number_under_which_nothing_could_be_written_is_void(quick, lab, tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(DataError, match="the certificate cannot be written"):
        issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    void = json.loads((lab / "numbers" / "SPECIMEN-DEMO-2026-0001.void.json").read_text("utf-8"))
    assert "cannot be written" in void["reason"]
    issued = issue(quick.loaded, lab, tmp_path / "other", registry=without_pdf())
    assert issued.certificate.number == "SPECIMEN-DEMO-2026-0002"
    assert issued.notes == ()


def test_a_number_that_a_crash_broke_off_is_told_at_the_next(quick, lab, tmp_path):
    (lab / "numbers").mkdir()
    (lab / "numbers" / "SPECIMEN-DEMO-2026-0001.json").write_text("")
    issued = issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert issued.certificate.number == "SPECIMEN-DEMO-2026-0002"
    assert issued.notes == ("SPECIMEN-DEMO-2026-0001 was reserved, but not issued",)


def test_files_are_made_again_if_another_process_takes_their_number(quick, lab, tmp_path):
    numbers, progressed = Numbers(lab, "SPECIMEN-DEMO"), []

    def progress(what, done, of):
        if what == MAKING:
            progressed.append((done, of))
        if progressed == [(1, 1)]:
            numbers.reserve(NOW.year, {"by": "another process"})

    issued = issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf(), progress=progress)
    assert progressed == [(1, 1)] * 2
    assert issued.certificate.number == "SPECIMEN-DEMO-2026-0002"
    for path in issued.files:
        assert path.stem == "SPECIMEN-DEMO-2026-0002"
        assert "SPECIMEN-DEMO-2026-0002" in path.read_text("utf-8")
        assert "SPECIMEN-DEMO-2026-0001" not in path.read_text("utf-8")


def test_a_form_that_cannot_be_made_takes_no_number(quick, lab, tmp_path, monkeypatch):
    def fail(*_args):
        raise DataError("no form")

    monkeypatch.setattr("rigrunner.documents.certifying.office.CertificateInput", fail)
    with pytest.raises(DataError, match="no form"):
        issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert not (lab / "numbers").exists()


def test_nothing_is_overwritten(quick, lab, tmp_path):
    mine = tmp_path / "out" / "SPECIMEN-DEMO-2026-0001.html"
    mine.parent.mkdir()
    mine.write_text("mine")
    with pytest.raises(DataError, match="File exists"):
        issue(quick.loaded, lab, tmp_path / "out", registry=without_pdf())
    assert mine.read_text() == "mine"
