from __future__ import annotations

import zlib

import pytest

from rigrunner.api.errors import DataError
from rigrunner.proof import contents

CONTENT = b'{"rigrunner": "certificate/1"}'
HTML = b'<!doctype html><script>let a = 1</script>\n<script id="c" type="application/json">'
DEFLATED = zlib.compress(CONTENT)
PDF = b"%PDF-1.7\n7 0 obj\n<</Type /EmbeddedFile /Length 38"


@pytest.fixture(autouse=True)
def parsed(monkeypatch):
    """Accept any text as a certificate: its content is tested elsewhere."""

    class Text(bytes):
        def model_copy(self, update):
            assert update == {"seal": None}
            return bytes(self)

    monkeypatch.setattr(contents, "parse_certificate", lambda text, _name: Text(text))


@pytest.mark.parametrize(
    ("suffix", "content"),
    [
        (".json", CONTENT),
        (".html", HTML + CONTENT + b"</script>"),
        (".pdf", PDF + b" /Filter /FlateDecode>> stream\n" + DEFLATED + b"\nendstream"),
        (".pdf", PDF + b">>\nstream\r\n" + CONTENT + b"endstream"),
        (
            ".pdf",
            PDF + b">>\nstream\nlogo\nendstream\nendobj\n" + PDF + b">>stream\n" + DEFLATED,
        ),
    ],
)
def test_content_is_found_in_each_form(suffix, content):
    assert contents.content_in(content, suffix, "C-1") == CONTENT


@pytest.mark.parametrize(
    ("suffix", "content"), [(".html", b"<p>"), (".pdf", b"%PDF"), (".pdf", PDF), (".html", HTML)]
)
def test_page_without_content_is_refused(suffix, content):
    with pytest.raises(DataError, match="C-1 carries no content of a certificate"):
        contents.content_in(content, suffix, "C-1")
