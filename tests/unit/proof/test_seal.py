from __future__ import annotations

import hashlib
import json
import random
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigrunner.api.errors import DataError
from rigrunner.proof.seal import FORMS, check_seal, seal, unsealed

JSON = (json.dumps({"a": "x" * 4000, "b": [1, 2]}, indent=1) + "\n").encode()
HTML = b"<!doctype html>\n<h1>Certificate</h1>\n" + b"<p>0.7273</p>\n" * 400
PDF = b"%PDF-1.7\n1 0 obj\n<<>>\nendobj\n" + b"x" * 9000 + b"\nstartxref\n9\n%%EOF\n"
DOCUMENTS = {".json": JSON, ".html": HTML, ".pdf": PDF}


@pytest.mark.parametrize("suffix", DOCUMENTS)
def test_sealed_document_is_intact_and_can_be_unsealed(suffix):
    sealed = seal(DOCUMENTS[suffix], suffix)
    assert check_seal(sealed, suffix) == []
    assert unsealed(sealed, suffix) == DOCUMENTS[suffix]
    assert unsealed(DOCUMENTS[suffix], suffix) == DOCUMENTS[suffix]


def test_seal_is_the_digest_of_the_preceding_content():
    *before, last = seal(HTML, ".html").splitlines(keepends=True)
    digest = hashlib.sha256(b"".join(before)).hexdigest()
    assert last.startswith(f"<!-- seal: sha256 {digest} blocks 512 ".encode())
    document = json.loads(seal(JSON, ".json"))
    assert document["seal"].startswith("sha256 ")
    assert [*document] == ["a", "b", "seal"]
    assert document["a"] == "x" * 4000


def test_end_mark_of_a_long_pdf_stays_near_the_end():
    """Readers look for %%EOF in the last 1024 bytes (ISO 32000-1, annex H, note 18)."""
    sealed = seal(b"%PDF" + bytes(3_000_000) + b"%%EOF\n", ".pdf")
    assert b"%%EOF" in sealed[-1024:]


@pytest.mark.parametrize("suffix", DOCUMENTS)
def test_every_changed_byte_is_located(suffix):
    sealed = seal(DOCUMENTS[suffix], suffix)
    body = len(unsealed(sealed, suffix)) - len(FORMS[suffix].opened)
    rng = random.Random(1)  # noqa: S311  (seeded, to be repeated)
    places = [0, body - 1, body, len(sealed) - 1, *(rng.randrange(len(sealed)) for _ in range(200))]
    for at in places:
        damaged = bytearray(sealed)
        damaged[at] ^= rng.randrange(1, 256)
        if at >= body:
            with pytest.raises(DataError, match="seal"):
                assert check_seal(bytes(damaged), suffix) == "found"
        else:
            (part,) = check_seal(bytes(damaged), suffix)
            assert part.start <= at < part.end
            assert part.end - part.start <= 512


def test_inserted_bytes_are_located_from_their_block_on():
    """All that follows is shifted: 700 more bytes are at least one more block of 512."""
    sealed = seal(HTML, ".html")
    (part,) = check_seal(sealed[:1500] + b"x" * 700 + sealed[1500:], ".html")
    assert (part.start, part.end) == (1024, len(HTML) + 700)


@given(st.binary(max_size=3000), st.sampled_from(list(FORMS)), st.data())
def test_insertions_and_deletions_are_detected(content, suffix, data):
    sealed = seal(content + FORMS[suffix].opened, suffix)
    at = data.draw(st.integers(0, len(sealed)))
    more = data.draw(st.binary(min_size=1, max_size=5))
    less = data.draw(st.integers(1, 5))
    for changed in (sealed[:at] + more + sealed[at:], sealed[:at] + sealed[at + less :]):
        if changed == sealed:
            continue
        with suppress(DataError):  # the seal itself is damaged: refused too
            assert check_seal(changed, suffix)


def test_document_without_a_seal_is_refused():
    for suffix, content in DOCUMENTS.items():
        with pytest.raises(DataError, match="there is no seal at its end"):
            check_seal(content, suffix)
    with pytest.raises(DataError, match=r"'\.txt' is not a kind of certificate"):
        seal(b"", ".txt")
    with pytest.raises(DataError, match="does not end as one that can be sealed"):
        seal(b"{}", ".json")
