"""A certificate is verified against its run, its other forms and its laboratory."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime

import h5py
import pytest

from helpers_certificate import issue, make_letterhead, without_pdf
from rigrunner.api.certificate import Restriction, certificate_json
from rigrunner.certificate.amending import amendment_of
from rigrunner.documents.verifying import certificate as verifying
from rigrunner.documents.verifying import run as verifying_run
from rigrunner.documents.verifying.certificate import Means, verify_certificate
from rigrunner.documents.verifying.document import Document, check_document, check_number
from rigrunner.documents.verifying.forms import Form
from rigrunner.documents.verifying.pages import _different_lines, page_maker
from rigrunner.documents.verifying.verification import Verification
from rigrunner.procedure import Acceptance
from rigrunner.registry import load_registry
from rigrunner.run.decisions import Decider, decide_again

pytestmark = pytest.mark.usefixtures("tester")
REGENERATED = "certificate regenerated from the run"


@pytest.fixture(scope="module")
def letterhead(tmp_path_factory):
    return make_letterhead(tmp_path_factory.mktemp("lab") / "letterhead")


@pytest.fixture(scope="module")
def issued(tester_runs, letterhead):
    """Return the file of a specimen on a run of the tests' own tester, and its content."""
    done = issue(tester_runs.loaded, letterhead, letterhead.parent / "out", registry=without_pdf())
    return done.files[0], done.certificate


@pytest.fixture
def certificate(issued):
    return issued[1]


def verified(path, run, letterhead, monkeypatch):
    # a process of its own, which takes half a second, is tested by itself
    monkeypatch.setattr(verifying_run, "refuse_crashing", lambda _path: None)
    means = Means(run=run, runs=run.parent, registry=load_registry(), letterhead=letterhead)
    return verify_certificate(path, means)


def test_changed_run_is_a_difference_of_its_certificate(
    issued, tester_runs, tmp_path, letterhead, monkeypatch
):
    run = shutil.copytree(tester_runs.loaded, tmp_path / tester_runs.loaded.name)
    (run / "run.h5").chmod(0o644)
    with h5py.File(run / "run.h5", "r+") as file:
        name = next(iter(file["entry/zeros"]))
        file[f"entry/zeros/{name}"][()] += 0.5
    differences = verified(issued[0], run, letterhead, monkeypatch).differences
    assert any(
        text.startswith("manifest of the run file: ") and name in text for text in differences
    )
    assert differences[-1].endswith("its differences are listed above")


def test_data_with_a_known_truth_are_simulated(issued, tester_runs, letterhead, monkeypatch):
    """Also where no device states that it is simulated."""
    monkeypatch.setattr(verifying, "is_simulated", lambda _provenance: False)
    monkeypatch.setattr(verifying, "read_truth", lambda _run: {"torque_nm": 0.7})
    monkeypatch.setattr("rigrunner.certificate.content.instruments_of", lambda *_: ())
    differences = verified(issued[0], tester_runs.loaded, letterhead, monkeypatch).differences
    assert any("instruments" in text for text in differences)  # so it was made again
    assert not any("restrictions" in text for text in differences)


def test_certificate_of_a_later_decision_is_made_again_by_that_decision(
    tester_runs, letterhead, tmp_path, monkeypatch
):
    run = shutil.copytree(tester_runs.loaded, tmp_path / tester_runs.loaded.name)
    who = Decider(by="A. Person", reason="new drawing", at=datetime(2026, 11, 22, tzinfo=UTC))
    limit = {"of": "torque", "max": "0.6 N·m", "source": "drawing 7"}
    acceptance = Acceptance.model_validate({"limits": [limit], "rule": "simple"})
    decide_again(run, load_registry(), who, lambda *_: acceptance)
    done = issue(run, letterhead, tmp_path / "out", registry=without_pdf())
    assert done.certificate.conformity.verdict == "fail"
    verification = verified(done.files[0], run, letterhead, monkeypatch)
    assert verification.differences == []
    assert REGENERATED in verification.held


@pytest.mark.parametrize(("code", "requested"), [("requested", True), ("simulated", False)])
def test_requested_specimen_is_made_again_as_one(certificate, monkeypatch, code, requested):
    asked = []
    monkeypatch.setattr(
        verifying, "restrictions_of", lambda _, *, requested: asked.append(requested) or ()
    )
    monkeypatch.setattr(verifying, "make_certificate", lambda *_: None)
    restricted = certificate.model_copy(update={"restrictions": (Restriction(code=code),)})
    verifying._made_again(restricted, None)
    assert asked == [requested]


def checked_with(other, certificate, path):
    verification = Verification()
    document = Document(
        path, [Form(path, path.read_bytes())], {path.name: certificate, "other.html": other}
    )
    check_document(verification, document, load_registry(), None, signed=False)
    return verification.differences


def test_forms_of_other_content_differ_in_what_is_other(issued):
    path, certificate = issued
    what = f"content of other.html is that of {path.name}"
    later = certificate.model_copy(update={"issued_utc": "2027-01-01T00:00:00.000Z"})
    (difference,) = checked_with(later, certificate, path)
    assert difference.startswith(f"{what}: issued_utc: ")
    (named,) = certificate.named
    value = named.found.value * (1 + 1e-9)
    found = named.found.model_copy(update={"value": value})
    close = certificate.model_copy(update={"named": (named.model_copy(update={"found": found}),)})
    (difference,) = checked_with(close, certificate, path)
    assert difference == f"{what}: its content differs by less than is printed"


@pytest.mark.parametrize("is_of_this_document", [True, False])
def test_amendment_beside_replaces_only_the_document_that_it_names(
    issued, tmp_path, is_of_this_document
):
    """Another laboratory may have issued the same number."""
    path, certificate = issued
    form = Form(tmp_path / path.name, path.read_bytes())
    (sha256,) = form.digests
    of = sha256 if is_of_this_document else "ab" * 32
    amends = amendment_of(certificate, of, "misspelt", "A. Nother")
    new = certificate.model_copy(update={"number": "DEMO-2026-0009", "amends": amends})
    (tmp_path / "DEMO-2026-0009.json").write_text(certificate_json(new), encoding="utf-8")
    verification = Verification()
    check_number(verification, [form], certificate, None)
    replaced = f"{certificate.number} is no longer in force, as DEMO-2026-0009 beside it says"
    assert verification.replaced == [replaced] * is_of_this_document


def test_laboratory_must_be_that_of_its_letterhead(certificate, letterhead):
    other = certificate.laboratory.model_copy(update={"name": "Other laboratory"})
    for forged, count in (
        (certificate, 0),
        (certificate.model_copy(update={"laboratory": other}), 1),
    ):
        verification = Verification()
        page_maker(verification, forged, load_registry(), letterhead)
        assert len(verification.differences) == count
        assert all("laboratory/name" in text for text in verification.differences)


def test_page_is_unproven_if_the_letterhead_was_changed(certificate, letterhead, tmp_path):
    changed = shutil.copytree(letterhead, tmp_path / "letterhead")
    (changed / "logo.svg").write_bytes(b"<svg/>")
    verification = Verification()
    maker = page_maker(verification, certificate, load_registry(), changed)
    assert (maker.letterhead, verification.differences) == (None, [])
    assert maker.why.endswith("is not the one it was issued with: logo.svg")


def test_line_without_words_is_shown_as_written():
    lines = list(_different_lines(b"<p>\n<b>\n</p>", b"<p>\n<i>\n</p>"))
    (line,) = lines
    assert line.endswith("it shows '<b>', its content gives '<i>'")
    (line,) = _different_lines(b"<p>\n<b>1.2</b>\n</p>", b"<p>\n<b>1.3</b>\n</p>")
    assert line.endswith("it shows '1.2', its content gives '1.3'")
