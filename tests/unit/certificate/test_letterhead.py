"""A letterhead is read strictly, and only from its own folder."""

from __future__ import annotations

import hashlib

import pytest

from helpers_certificate import make_letterhead
from rigrunner.api.errors import InvalidFileError, UsageError
from rigrunner.certificate.letterhead import read_letterhead


@pytest.fixture
def lab(tmp_path):
    return make_letterhead(tmp_path / "letterhead")


def edit_letterhead(lab, old, new):
    path = lab / "letterhead.yaml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    return lab


def test_letterhead_of_a_new_lab_folder_is_complete(lab):
    letterhead = read_letterhead(lab)
    assert letterhead.laboratory.name == "Demonstration laboratory (fictitious)"
    assert (letterhead.language, letterhead.prefix) == ("en", "DEMO")
    assert letterhead.logo.content == (lab / "logo.svg").read_bytes()
    assert letterhead.logo.media_type == "image/svg+xml"
    assert letterhead.files == {
        name: hashlib.sha256((lab / name).read_bytes()).hexdigest()
        for name in ("letterhead.yaml", "logo.svg")
    }


def test_language_can_be_chosen(lab):
    assert read_letterhead(lab, "de").language == "de"


def test_own_texts_templates_and_style_are_read(lab):
    for name in ("texts", "templates"):
        (lab / name).mkdir()
    (lab / "texts" / "en.yaml").write_text("rigrunner: texts/1\ntexts: {title: Report}\n")
    (lab / "templates" / "head.html.j2").write_text("<p>head</p>")
    (lab / "style.css").write_text("h1 { color: red }")
    letterhead = read_letterhead(lab)
    assert letterhead.texts == {"en": {"title": "Report"}}
    assert letterhead.templates == {"head.html.j2": "<p>head</p>"}
    assert letterhead.style == "h1 { color: red }"
    assert {"texts/en.yaml", "templates/head.html.j2", "style.css"} <= set(letterhead.files)


def test_missing_folder_is_refused_with_a_hint_to_init(tmp_path):
    with pytest.raises(UsageError, match=r"no letterhead.yaml.*rigrunner init"):
        read_letterhead(tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("file: logo.svg", "file: logo.gif", "is not a picture"),
        ("file: logo.svg", "file: other.svg", "there is no file"),
        ("file: logo.svg", "file: ../outside.svg", "outside the letterhead folder"),
        ("prefix: DEMO", "prefix: A/B", "prefix"),
        ("prefix: DEMO", "prefx: DEMO", "did you mean 'prefix'"),
        ("language: en", "language: English", "language"),
        ("  place: at", "  plase: at", "place"),
    ],
)
def test_problem_is_reported_with_its_location(lab, old, new, message):
    (lab.parent / "outside.svg").write_text("<svg/>")
    with pytest.raises(InvalidFileError, match=rf"letterhead\.yaml:\d+:\d+: .*{message}"):
        read_letterhead(edit_letterhead(lab, old, new))
