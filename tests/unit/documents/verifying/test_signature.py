"""The check of a document's signature: signer, signed files, and trust in the key."""

from __future__ import annotations

import hashlib
from types import SimpleNamespace

import pytest

from rigrunner.documents.verifying.signature import UNSIGNED, check_signature_of
from rigrunner.documents.verifying.verification import Verification
from rigrunner.proof.keys import new_key, read_private_key
from rigrunner.proof.signature import sign_files, signature_json

FILES = {"C-1.json": b"{}", "C-1.html": b"<p>"}


def form(name, content):
    return SimpleNamespace(name=name, digests={hashlib.sha256(content).hexdigest()})


FORMS = [form(name, content) for name, content in FILES.items()]


@pytest.fixture
def keys(tmp_path):
    """Return the public key of the signer, and another one."""
    for name in ("lab.key", "other.key"):
        new_key(tmp_path / name)
    return tmp_path / "lab.key.pub", tmp_path / "other.key.pub"


@pytest.fixture
def path(tmp_path, keys):
    signature = sign_files(FILES, read_private_key(keys[0].with_suffix("")), "Zoe", "2026-03-01")
    (tmp_path / "C-1.sig.json").write_text(signature_json(signature), encoding="utf-8")
    return tmp_path / "C-1.sig.json"


def check(path, forms=FORMS, trusted=()):
    verification = Verification()
    return check_signature_of(verification, path, forms, trusted), verification


def test_document_signed_by_a_trusted_key_is_signed(path, keys):
    is_signed, verification = check(path, trusted=keys)
    assert is_signed
    assert verification.differences == []
    assert verification.held[0] == "signature C-1.sig.json"
    assert verification.held[1].startswith("signed by Zoe at 2026-03-01, key ")
    assert verification.held[1].endswith(", which is trusted")


def test_unknown_key_is_a_difference_only_if_trusted_keys_are_given(path, keys):
    is_signed, verification = check(path)
    assert not is_signed
    assert verification.differences == []
    assert "whether that key is theirs is not known" in verification.information[0]
    is_signed, verification = check(path, trusted=keys[1:])
    assert not is_signed
    assert verification.differences[0].endswith("which is not among the trusted keys")


def test_missing_signature_is_a_difference_only_if_trusted_keys_are_given(path, keys):
    missing = path.with_name("C-2.sig.json")
    is_signed, verification = check(missing)
    assert not is_signed
    assert (verification.differences, verification.information) == ([], [UNSIGNED])
    is_signed, verification = check(missing, trusted=keys)
    assert not is_signed
    assert (verification.differences, verification.information) == ([UNSIGNED], [])


@pytest.mark.parametrize(
    ("forms", "text"),
    [
        ([*FORMS, form("C-1.pdf", b"%PDF")], "C-1.pdf is not signed"),
        ([FORMS[0], form("C-1.html", b"<P>")], "C-1.html is not the file that was signed"),
    ],
)
def test_unsigned_or_changed_form_is_a_difference(path, keys, forms, text):
    is_signed, verification = check(path, forms, trusted=keys)
    assert not is_signed
    assert verification.differences == [f"signature C-1.sig.json: {text}"]


@pytest.mark.parametrize("change", [('"signer": "Zoe"', '"signer": "Ada"'), ('"files"', '"file"')])
def test_invalid_signature_is_a_difference(path, keys, change):
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    is_signed, verification = check(path, trusted=keys)
    assert is_signed is False
    assert len(verification.differences) == 1
    assert verification.differences[0].startswith("signature C-1.sig.json: ")
    assert verification.held == []
