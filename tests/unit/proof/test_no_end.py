"""A stranger's certificate that leaves out the ends of what is looked for is read in no time."""

from __future__ import annotations

import time

import pytest
from pypdf.generic import DecodedStreamObject

from rigrunner.api.errors import DataError
from rigrunner.documents.verifying import pages
from rigrunner.proof.contents import content_in
from rigrunner.proof.pdf import metadata_texts
from rigrunner.proof.places import place_in
from rigrunner.proof.seal import issued_part

MANY = 20_000
MOST_S = 4.0
"""Of the processor; looked for from each beginning to the end of the file, it took 5 to 60 s."""


def places(text):
    place_in(text * MANY, ".html", 3, 5)


def content(text):
    with pytest.raises(DataError):
        content_in(text * MANY, ".html", "c.html")


def attachments(text):
    with pytest.raises(DataError):
        content_in(text * MANY, ".pdf", "c.pdf")


def lines(text):
    lines = [b"%d" % (number % 7) for number in range(500)]
    list(pages._different_lines(text * MANY, b"\n".join(lines)))


def shown(text):
    pages._text_of_html(text * MANY)


def metadata(text):
    stream = DecodedStreamObject()
    stream.set_data(text * MANY)
    metadata_texts(stream)


def appended(text):
    issued_part(text * MANY, ".pdf")


@pytest.mark.parametrize(
    ("look", "text"),
    [
        (places, b"<h1>"),
        (places, b"<h1 <"),
        (content, b'<script type="application/json">'),
        (content, b"<script type=<"),
        (attachments, b"/EmbeddedFile stream\n" + b"x" * 200),
        (lines, b'<img class="logo"'),
        (lines, b"1\n2\n"),
        (lines, b"<"),
        (shown, b"<script "),
        (shown, b"<style>"),
        (metadata, b"<a"),
        (metadata, b"<a>b"),
        (metadata, b" a"),
        (metadata, b"<aaaa:"),
        (appended, b"% seal: sha256 "),
        (appended, b"% seal: sha256 " + b"0" * 64 + b" blocks 512 \n"),
    ],
)
def test_what_has_no_end_is_not_looked_for_again_and_again(look, text):
    look(b"")  # imports what it needs
    before_s = time.process_time()
    look(text)
    assert time.process_time() - before_s < MOST_S
