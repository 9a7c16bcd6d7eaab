"""Only forms as they were issued are signed."""

from __future__ import annotations

import shutil

import pytest

from e2e.helpers_forgery import forged_pdf, resealed
from helpers_certificate import issue, make_letterhead, without_pdf
from helpers_cli import call
from helpers_lacking import require_pdf
from rigrunner.proof.signature import parse_signature


@pytest.fixture(scope="module")
def issued(quick, tmp_path_factory):
    """Issue two specimen certificates on a run, one with a PDF; return letterhead and folder."""
    require_pdf()
    folder = tmp_path_factory.mktemp("laboratory")
    letterhead = make_letterhead(folder / "letterhead")
    issue(quick.loaded, letterhead, folder / "certificates")
    issue(quick.loaded, letterhead, folder / "certificates", registry=without_pdf())
    return letterhead, folder / "certificates"


@pytest.fixture
def with_pdf(issued, tmp_path):
    folder = shutil.copytree(issued[1], tmp_path / "certificates")
    return folder / "SPECIMEN-DEMO-2026-0001.json"


@pytest.fixture
def certificate(with_pdf):
    """Return a certificate as JSON and HTML only: regenerating its PDF takes seconds."""
    with_pdf.with_suffix(".pdf").unlink()
    return with_pdf


@pytest.fixture
def key(tmp_path):
    assert call("sign", "--new-key", tmp_path / "k").code == 0
    return tmp_path / "k"


def sign(certificate, key, letterhead, *more):
    return call(
        "sign", certificate, "--key", key, "--by", "Zoë", "--letterhead", letterhead, *more
    )  # fmt: skip


def test_every_form_is_signed_once(issued, with_pdf, key):
    result = sign(with_pdf, key, issued[0])
    assert (result.code, result.out.strip()) == (0, str(with_pdf.with_suffix(".sig.json"))), (
        result.err
    )
    signature = parse_signature(with_pdf.with_suffix(".sig.json").read_bytes(), "x")
    assert set(signature.files) == {f"{with_pdf.stem}{s}" for s in (".json", ".html", ".pdf")}
    assert signature.signer == "Zoë"
    repeated = sign(with_pdf, key, issued[0])
    assert (repeated.code, "the document is signed" in repeated.err) == (2, True)


def test_passphrase_is_taken_from_its_environment_variable(
    issued, certificate, tmp_path, monkeypatch
):
    monkeypatch.setenv("RIGRUNNER_PASSPHRASE", "sesame")
    assert call("sign", "--new-key", tmp_path / "p", "--passphrase").code == 0
    result = sign(certificate, tmp_path / "p", issued[0])
    assert "is protected by a passphrase" in result.err
    assert sign(certificate, tmp_path / "p", issued[0], "--passphrase").code == 0


def refusal(certificate, key, letterhead):
    """Return the reason why a document is not signed."""
    result = sign(certificate, key, letterhead)
    assert (result.code, result.out) == (5, ""), result
    assert not certificate.with_suffix(".sig.json").exists()
    return result.err


def test_changed_form_is_refused_with_the_location(issued, certificate, key):
    page = certificate.with_suffix(".html")
    page.write_bytes(page.read_bytes().replace(b"Muster", b"Master", 1))
    assert "seal of SPECIMEN-DEMO-2026-0001.html: changed at bytes" in refusal(
        certificate, key, issued[0]
    )


def test_page_that_contradicts_its_content_is_refused(issued, certificate, key):
    page = certificate.with_suffix(".html")
    resealed(page, lambda content: content.replace(b'<p class="value">', b'<p class="value">0.1 '))
    assert ".html regenerated from its content: at bytes" in refusal(certificate, key, issued[0])


@pytest.mark.thorough
def test_pdf_that_contradicts_its_content_is_refused(issued, with_pdf, key):
    """Its embedded data equal the JSON; the page shows another result."""
    printed = forged_pdf(with_pdf.with_suffix(".pdf"))
    assert f".pdf regenerated from its content: it shows '{printed}'" in refusal(
        with_pdf, key, issued[0]
    )


def test_form_of_another_certificate_is_refused(issued, certificate, key):
    second = certificate.with_name("SPECIMEN-DEMO-2026-0002.html")
    shutil.copyfile(second, certificate.with_suffix(".html"))
    text = refusal(certificate, key, issued[0])
    assert "content of SPECIMEN-DEMO-2026-0001.html is that of SPECIMEN-DEMO-2026-0001.json" in text


def test_document_that_is_not_on_record_is_refused(issued, certificate, key, tmp_path):
    copy = shutil.copytree(issued[0], tmp_path / "copy")
    shutil.rmtree(copy / "numbers")
    assert "has no record of numbers" in refusal(certificate, key, copy)
    certificate.with_suffix(".html").unlink()
    resealed(certificate, lambda content: content.replace(b"Muster", b"Master"))
    assert "SPECIMEN-DEMO-2026-0001.json is not as it was issued" in refusal(
        certificate, key, issued[0]
    )


def test_withdrawn_certificate_is_refused(issued, certificate, key, tmp_path):
    letterhead = shutil.copytree(issued[0], tmp_path / "letterhead")
    words = ("--reason", "the wrong item", "--by", "B", "--letterhead", letterhead)
    assert call("withdraw", certificate, *words).code == 0
    assert "is no longer in force: withdrawn by B on 20" in refusal(certificate, key, letterhead)


@pytest.mark.thorough
def test_replaced_certificate_is_refused(issued, certificate, key, tmp_path):
    letterhead = shutil.copytree(issued[0], tmp_path / "letterhead")
    result = call(
        "amend", certificate, "--reason", "misspelt", "--by", "B", "--customer", "Other",
        "--letterhead", letterhead, "--out", tmp_path / "amended",
    )  # fmt: skip
    assert result.code == 0, result.err
    assert "SPECIMEN-DEMO-2026-0003 replaced it" in refusal(certificate, key, letterhead)
