"""A stranger's certificate that leaves out the ends of what is looked for is read in no time."""

from __future__ import annotations

import time

import pytest

from rigrunner.api.errors import DataError
from rigrunner.proof.contents import content_in
from rigrunner.proof.places import place_in
from rigrunner.workflow.verifying import pages

MANY = 20_000
MOST_S = 3.0
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
    made = [b"%d" % (number % 7) for number in range(500)]
    list(pages._different_lines(text * MANY, b"\n".join(made), whole=False))


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
    ],
)
def test_what_has_no_end_is_not_looked_for_again_and_again(look, text):
    before_s = time.process_time()
    look(text)
    assert time.process_time() - before_s < MOST_S
