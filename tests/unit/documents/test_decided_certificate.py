"""The certificate of a run that was decided again, and its verification."""

from __future__ import annotations

import re
import shutil
from datetime import UTC, datetime

import pytest

from helpers_certificate import issue, make_letterhead, without_pdf
from rigrunner.api.errors import DataError, UsageError
from rigrunner.certificate.amending import amended, amendment_of
from rigrunner.certificate.content import Issue
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.documents.certifying.amend import _conformity_in_force
from rigrunner.documents.verifying.certificate import Means, verify_certificate
from rigrunner.documents.verifying.decisions import check_decisions
from rigrunner.documents.verifying.forms import Form
from rigrunner.documents.verifying.pages import check_page, page_maker
from rigrunner.documents.verifying.verification import Verification
from rigrunner.procedure import Acceptance
from rigrunner.proof.seal import seal, unsealed
from rigrunner.registry import load_registry
from rigrunner.run.decisions import Decider, decide_again
from rigrunner.runfile import read

DECIDED = datetime(2026, 11, 22, 9, tzinfo=UTC)
"""Half an hour before the certificate is issued."""
LIMIT = {
    "of": "torque",
    "mean": True,
    "max": "0.6 N·m",
    "source": "drawing 7",
    "measurand": {"nature": "load_induced", "condition": "at_reversal"},
}
TIGHT = Acceptance.model_validate({"limits": [LIMIT], "rule": "simple"})


@pytest.fixture(scope="module")
def certified(quick_copy, tmp_path_factory):
    """Return a run, passed by its procedure and failed by a later decision, and its certificate."""
    folder = tmp_path_factory.mktemp("lab")
    loaded = quick_copy.loaded
    who = Decider(by="A. Person", reason="the drawing was <changed>", at=DECIDED)
    decide_again(loaded, load_registry(), who, lambda *_: TIGHT)
    letterhead = make_letterhead(folder / "letterhead")
    return loaded, issue(loaded, letterhead, folder / "certificates", registry=without_pdf())


@pytest.fixture
def folder(certified, tmp_path):
    return shutil.copytree(certified[0], tmp_path / certified[0].name)


@pytest.fixture
def certificate(certified):
    return certified[1].certificate


def verification_of(certificate, folder):
    verification = Verification()
    check_decisions(verification, certificate, read(folder), folder)
    return verification


def test_certificate_states_the_decision_in_force_and_its_record(certified):
    issued = certified[1]
    conformity = issued.certificate.conformity
    (record,) = conformity.decided_again

    assert (conformity.verdict, conformity.rule) == ("fail", "simple")
    assert conformity.statements[0].source == "drawing 7"
    assert (record.by, record.reason) == ("A. Person", "the drawing was <changed>")
    assert record.decided_utc == "2026-11-22T09:00:00.000Z"
    assert (record.verdict_before, record.limit_before) == ("pass", "≤ 0.95 N·m")
    assert any("states 'fail' by decision-2.json" in note for note in issued.notes)
    page = next(path for path in issued.files if path.suffix == ".html").read_text("utf-8")
    assert "Decided again on the same recordings" in page
    assert "the drawing was &lt;changed&gt;" in page


@pytest.mark.thorough
def test_verification_derives_the_verdict_by_the_decision_in_force(certified, tmp_path):
    loaded, issued = certified
    letterhead = issued.files[0].parent.parent / "letterhead"
    means = Means(run=loaded, runs=loaded.parent, registry=load_registry(), letterhead=letterhead)
    verification = verify_certificate(issued.files[0], means)
    assert verification.matches, verification
    assert "decisions on record beside the run" in verification.held

    forged = tmp_path / issued.files[0].name
    text = issued.files[0].read_text("utf-8")
    forged.write_text(text.replace('"verdict": "fail"', '"verdict": "pass"'), "utf-8")
    differences = "\n".join(verify_certificate(forged, means).differences)
    assert (
        "certificate regenerated from the run: conformity/verdict: 'pass' is recorded"
        in differences
    )


def test_changed_decision_record_is_a_difference(certificate, folder):
    path = folder / "decision-2.json"
    path.write_text(path.read_text("utf-8").replace("A. Person", "B. Person"), "utf-8")

    differences = "\n".join(verification_of(certificate, folder).differences)
    assert "decision-2.json/by: 'A. Person' is recorded, 'B. Person' was derived" in differences
    assert "decision-2.json/sha256" in differences


def test_missing_decision_record_is_unchecked(certificate, folder):
    (folder / "decision-2.json").unlink()
    verification = verification_of(certificate, folder)
    assert not verification.differences
    assert not verification.held
    assert verification.unchecked[0].startswith("decision-2.json is not beside the run")


def test_unreadable_decision_record_is_a_difference(certificate, folder):
    (folder / "decision-2.json").write_text("{}", "utf-8")
    assert (
        "is not a decision that can be read" in verification_of(certificate, folder).differences[0]
    )


def test_decision_omitted_by_the_certificate_is_a_difference(certificate, folder):
    without_decision = certificate.conformity.model_copy(update={"decided_again": ()})
    without_record = certificate.model_copy(update={"conformity": without_decision})
    (difference,) = verification_of(without_record, folder).differences
    assert "decision-2.json of 2026-11-22T09:00:00.000Z decides 'fail'" in difference


def test_decision_after_the_issue_is_only_reported(certificate, folder):
    without_decision = certificate.conformity.model_copy(update={"decided_again": ()})
    issued = {"conformity": without_decision, "issued_utc": "2026-11-22T08:59:59.000Z"}
    verification = verification_of(certificate.model_copy(update=issued), folder)
    assert verification.matches
    assert "decided again after this certificate was issued: 'fail' by A. Person" in "".join(
        verification.information
    )


@pytest.mark.thorough
def test_amendment_states_the_decision_in_force(certified, certificate):
    silent = certificate.conformity.model_copy(
        update={"decided_again": (), "verdict": "pass", "rule": "guard_band_u"}
    )
    original = certificate.model_copy(update={"conformity": silent})
    loaded, issued = certified
    decided = _conformity_in_force(original, loaded, load_registry())
    letterhead = read_letterhead(issued.files[0].parent.parent / "letterhead", "en")
    issue = Issue(
        number="X-2026-0002",
        issued_utc="2026-11-23T00:00:00.000Z",
        authorisation=certificate.authorisation,
        restrictions=certificate.restrictions,
        software={},
        amends=amendment_of(original, "ab" * 32, "the drawing was changed", "A. Nother"),
    )
    amendment = amended(original, {}, letterhead, issue, decided)
    assert amendment.conformity == certificate.conformity
    changes = {change.field: (change.before, change.after) for change in amendment.amends.changes}
    assert changes == {
        "conformity.verdict": ("pass", "fail"),
        "conformity.rule": ("guard_band_u", "simple"),
    }
    older = certificate.evidence.model_copy(update={"revisions": {"analysis": 99}})
    by_older_analysis = original.model_copy(update={"evidence": older})
    with pytest.raises(DataError, match=r"analysis has revision \d+, .* is by revision 99"):
        _conformity_in_force(by_older_analysis, loaded, load_registry())
    run = certificate.evidence.run.model_copy(update={"run_id": "another"})
    evidence = certificate.evidence.model_copy(update={"run": run})
    of_other_run = certificate.model_copy(update={"evidence": evidence})
    with pytest.raises(DataError, match="is not the run of"):
        _conformity_in_force(of_other_run, loaded, load_registry())
    with pytest.raises(UsageError, match="already states the decision in force"):
        amended(certificate, {}, letterhead, issue, decided)


def test_raw_peaks_and_cycles_equal_those_of_the_report(certificate, folder):
    recorded_points = read(folder).result_document["points"]
    for point, recorded in zip(certificate.results.points, recorded_points, strict=True):
        assert point.raw_nm == pytest.approx(recorded["raw_peak"]["mean"]["value"])
        used = point.cycles - point.cycles_rejected
        assert used == recorded["waveform"]["cycles_kept"], "the primary method uses whole swings"


def test_changed_figure_is_unproven_and_changed_text_a_difference(certified, tmp_path):
    page = next(path for path in certified[1].files if path.suffix == ".html")
    content = unsealed(page.read_bytes(), ".html")
    figure = rb'(?<=<img src="data:image/svg\+xml;base64,)[^"]+'
    redrawn, count = re.subn(figure, b"PHN2Zy8+", content)
    assert count == 1
    forged = content.replace(b" Hz: 0.", b" Hz: 1.", 1)
    assert forged != content
    letterhead = page.parent.parent / "letterhead"
    for shown_content, differences, unproven in ((content, 0, 0), (redrawn, 0, 1), (forged, 1, 0)):
        verification = Verification()
        maker = page_maker(verification, certified[1].certificate, load_registry(), letterhead)
        form = Form(tmp_path / page.name, seal(shown_content, ".html"))
        check_page(verification, form, maker, signed=False)
        counts = (len(verification.differences), len(verification.unproven))
        assert counts == (differences, unproven), verification
