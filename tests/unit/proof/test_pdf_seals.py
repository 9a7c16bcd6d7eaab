"""A PDF that was sealed by standard means after its issue is as issued; a changed one is not."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest
from pypdf import PdfWriter
from pypdf.generic import DictionaryObject, NameObject, NullObject, NumberObject

from e2e.helpers_forgery import appended, sealed_pdf
from rigrunner.api.errors import DataError
from rigrunner.documents.verifying.document import _check_appended
from rigrunner.documents.verifying.forms import Form
from rigrunner.documents.verifying.verification import Verification
from rigrunner.proof.pdf import _Comparison, first_difference, reader
from rigrunner.proof.pdf_seals import additions_to
from rigrunner.proof.seal import issued_part

generic = pytest.importorskip("pyhanko.pdf_utils.generic")
ISSUED = (
    Path(__file__).parents[2] / "data/0.1.0/certificates/SPECIMEN-DEMO-2026-0001.pdf"
).read_bytes()


def first_page(writer):
    return writer.root["/Pages"]["/Kids"][0]


def test_an_issued_file_has_nothing_appended():
    assert issued_part(ISSUED, ".pdf") == ISSUED


def test_seal_keeps_the_issued_bytes_and_draws_nothing():
    sealed = sealed_pdf(ISSUED)
    assert issued_part(sealed, ".pdf") == ISSUED
    additions = additions_to(ISSUED, sealed)
    assert (additions.changed, additions.drawn, additions.seals) == ([], [], ["Seal"])


def test_field_created_before_its_seal_is_accepted():
    from pyhanko.sign import fields  # noqa: PLC0415  (loads much)

    first = appended(
        ISSUED, lambda writer: fields.append_signature_field(writer, fields.SigFieldSpec("Empty"))
    )
    additions = additions_to(ISSUED, sealed_pdf(first))
    assert (additions.changed, additions.drawn, additions.seals) == ([], [], ["Seal"])


def test_two_successive_seals_are_accepted():
    additions = additions_to(ISSUED, sealed_pdf(sealed_pdf(ISSUED), name="Second"))
    assert (additions.changed, additions.drawn, additions.seals) == ([], [], ["Seal", "Second"])


def test_visible_seal_is_reported():
    additions = additions_to(ISSUED, sealed_pdf(ISSUED, box=(50, 50, 300, 500)))
    assert (additions.changed, additions.drawn) == ([], ["the signature 'Seal' on page 1"])


def replace_content(writer):
    page = first_page(writer)
    page["/Contents"] = writer.add_object(generic.StreamObject(stream_data=b"BT ET"))
    writer.update_container(page)


def edit_content(writer):
    content = first_page(writer)["/Contents"]
    content._data, content._encoded_data = b"BT ET", None
    writer.update_container(content)


def edit_font(writer):
    fonts = first_page(writer)["/Resources"]["/Font"]
    font = fonts[next(iter(fonts))]
    font["/BaseFont"] = generic.NameObject("/Other")
    writer.update_container(font)


def draw_over(writer):
    note = generic.DictionaryObject(
        {
            generic.NameObject("/Type"): generic.NameObject("/Annot"),
            generic.NameObject("/Subtype"): generic.NameObject("/FreeText"),
            generic.NameObject("/Rect"): generic.ArrayObject(
                map(generic.NumberObject, (0, 0, 9, 9))
            ),
            generic.NameObject("/Contents"): generic.pdf_string("0.1000"),
        }
    )
    page = first_page(writer)
    page["/Annots"] = generic.ArrayObject([writer.add_object(note)])
    writer.update_container(page)


def crop(writer):
    page = first_page(writer)
    page["/CropBox"] = generic.ArrayObject(map(generic.NumberObject, (0, 0, 9, 9)))
    writer.update_container(page)


def other_pages(writer):
    pages = writer.root["/Pages"]
    writer.root["/Pages"] = writer.add_object(generic.DictionaryObject(dict(pages)))
    writer.update_root()


def act_when_opened(writer):
    writer.root["/OpenAction"] = generic.DictionaryObject(
        {generic.NameObject("/S"): generic.NameObject("/JavaScript")}
    )
    writer.update_root()


def retitle(writer):
    metadata = writer.root["/Metadata"]
    metadata._data = metadata.data.replace(b"Test certificate", b"Rest certificate")
    metadata._encoded_data = None
    writer.update_container(metadata)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (replace_content, "/Contents of page 1 was changed"),
        (edit_content, "was changed"),
        (edit_font, "was changed"),
        (draw_over, "an annotation that is not a signature was added to page 1"),
        (crop, "/CropBox of page 1 was changed"),
        (other_pages, "/Pages of the catalogue was changed"),
        (act_when_opened, "/OpenAction of the catalogue was changed"),
        (retitle, "the metadata were changed"),
    ],
)
@pytest.mark.parametrize("sealed", [False, True])
def test_other_appended_changes_are_reported(change, message, sealed):
    """Also under a seal that is valid: it says who appended it, not that it is harmless."""
    forged = appended(ISSUED, change)
    additions = additions_to(ISSUED, sealed_pdf(forged) if sealed else forged)
    assert any(message in line for line in additions.changed), additions
    no_seal = "what was appended is not a signature of the rest"
    assert sealed or no_seal in additions.changed


@pytest.mark.parametrize("old", [b"/Filter /Adobe.PPKLite", b"/Type /Sig\n", b"/Size "])
def test_changed_seal_is_not_a_signature(old):
    """Also where the change draws nothing."""
    sealed = sealed_pdf(ISSUED)
    end = sealed.rindex(old) + len(old) - 1
    changed = sealed[:end] + bytes([sealed[end] ^ 1]) + sealed[end + 1 :]
    try:
        additions = additions_to(ISSUED, changed)
    except DataError:
        return
    assert additions.changed == ["what was appended is not a signature of the rest"]


def test_appended_bytes_are_unproven_without_pypdf(monkeypatch, tmp_path):
    for name in ("rigrunner.proof.pdf", "rigrunner.proof.pdf_seals"):
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pypdf", None)
    verification = Verification()
    _check_appended(verification, Form(tmp_path / "x.pdf", sealed_pdf(ISSUED)))
    assert not verification.differences
    assert "the package 'pypdf' is not installed" in verification.unproven[0]


def test_objects_missing_from_the_tables_are_refused():
    """A program that scans for objects shows another page than one that uses the tables."""
    sealed = sealed_pdf(ISSUED)
    hidden = sealed.replace(b"startxref", b"5 0 obj\n<<>>\nendobj\nstartxref").replace(
        ISSUED.replace(b"startxref", b"5 0 obj\n<<>>\nendobj\nstartxref"), ISSUED
    )
    assert hidden != sealed
    with pytest.raises(DataError, match="do not list the objects"):
        additions_to(ISSUED, hidden)


def test_second_pdf_header_is_refused():
    """A program may read the file from there."""
    with pytest.raises(DataError, match="the PDF's tables do not list the objects in it"):
        reader(ISSUED.replace(b"startxref", b"%PDF-1.7\nstartxref"))


def add_a_field(writer):
    field = generic.DictionaryObject(
        {
            generic.NameObject("/FT"): generic.NameObject("/Tx"),
            generic.NameObject("/T"): generic.pdf_string("remark"),
        }
    )
    fields = generic.ArrayObject([writer.add_object(field)])
    writer.root["/AcroForm"] = generic.DictionaryObject({generic.NameObject("/Fields"): fields})
    writer.update_root()


def test_field_other_than_a_signature_is_a_change():
    additions = additions_to(ISSUED, appended(ISSUED, add_a_field))
    assert "a field that is not a signature was added" in additions.changed
    assert additions.seals == []


@pytest.mark.parametrize("content", [b"", b"%PDF-1.7\n", ISSUED[: len(ISSUED) // 2], ISSUED[9:]])
def test_unreadable_pdf_is_refused(content):
    with pytest.raises(DataError, match="PDF"):
        additions_to(ISSUED, content)
    with pytest.raises(DataError, match="PDF"):
        first_difference(content, ISSUED)


def test_rewritten_pdf_with_the_same_pages_is_equal():
    writer, out = PdfWriter(clone_from=io.BytesIO(ISSUED)), io.BytesIO()
    writer.write(out)
    assert out.getvalue() != ISSUED
    assert first_difference(out.getvalue(), ISSUED) == ""


@pytest.mark.parametrize("change", [replace_content, edit_content, edit_font, draw_over, crop])
def test_changed_drawing_is_a_difference(change):
    assert first_difference(appended(ISSUED, change), ISSUED) != ""


@pytest.mark.parametrize(
    ("one", "other", "place"),
    [
        (DictionaryObject({NameObject("/A"): NumberObject(1)}), NullObject(), "the catalogue"),
        (NumberObject(1), NullObject(), "/A"),
    ],
)
def test_object_of_another_type_is_located(one, other, place):
    where = "" if place == "the catalogue" else place
    assert list(_Comparison(bytes.__eq__).differences(one, other, where)) == [place]
