from __future__ import annotations

import base64
import hashlib
import json
import os
import shutil
import stat
import subprocess

import pytest

from helpers_cli import call
from rigrunner.api.errors import DataError, UsageError
from rigrunner.proof.keys import (
    fingerprint,
    new_key,
    public_pem,
    read_private_key,
    read_public_keys,
)
from rigrunner.proof.signature import (
    check_signature,
    parse_signature,
    sign_files,
    signature_json,
)

FILES = {"C-1.json": b"{}", "C-1.html": b"<p>"}


@pytest.fixture
def key(tmp_path):
    new_key(tmp_path / "lab.key")
    return tmp_path / "lab.key"


def signed(key):
    return sign_files(FILES, read_private_key(key), "Zoë", "2026-03-01T12:00:00.000Z")


def test_signature_is_verified_by_its_key(key):
    parsed = parse_signature(signature_json(signed(key)).encode(), "C-1.sig.json")
    assert parsed == signed(key)
    (public,) = read_public_keys(key.with_name("lab.key.pub"))
    assert public_pem(check_signature(parsed)) == public_pem(public)


@pytest.mark.parametrize(
    "change",
    [
        {"signer": "Another"},
        {"signed_utc": "2026-03-01T12:00:00.001Z"},
        {"files": {"C-1.json": "0" * 64}},
        {"signature": base64.b64encode(bytes(64)).decode()},
        {"signature": "?"},
        {"public_key": "another"},
        {"public_key": ""},
    ],
)
def test_any_change_invalidates_a_signature(key, tmp_path, change):
    new_key(tmp_path / "other.key")
    if change.get("public_key") == "another":
        change = {"public_key": (tmp_path / "other.key.pub").read_text()}
    content = json.loads(signature_json(signed(key))) | change
    with pytest.raises(DataError, match=r"not valid|cannot be read"):
        check_signature(parse_signature(json.dumps(content).encode(), "x"))


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"null", b'{"a": 1}', b"\xff", b"[" * 100_000, b'"x"']
)
def test_invalid_signature_file_is_refused(content):
    with pytest.raises(DataError, match="is not a signature file"):
        parse_signature(content, "C-1.sig.json")


def test_private_key_is_owner_only_and_never_overwritten(key):
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    with pytest.raises(UsageError, match="never overwritten"):
        new_key(key)
    key.unlink()
    with pytest.raises(UsageError, match="never overwritten"):
        new_key(key)


def test_key_made_at_the_same_time_is_not_overwritten(tmp_path):
    path = tmp_path / "lab.key"
    path.write_text("of another process", encoding="utf-8")
    with pytest.raises(UsageError, match=r"lab\.key exists") as caught:
        new_key(path)
    assert caught.value.hint == "keys are never overwritten"
    assert path.read_text(encoding="utf-8") == "of another process"
    assert [file.name for file in tmp_path.iterdir()] == ["lab.key"]


def test_protected_key_needs_its_passphrase(tmp_path):
    path = tmp_path / "lab.key"
    new_key(path, "open sesame")
    assert read_private_key(path, "open sesame")
    with pytest.raises(UsageError, match="is protected by a passphrase"):
        read_private_key(path)
    with pytest.raises(UsageError, match="or the passphrase is wrong"):
        read_private_key(path, "wrong")


def test_unprotected_key_refuses_a_passphrase(key):
    with pytest.raises(UsageError, match="has no passphrase"):
        read_private_key(key, "one")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no modes of files")
@pytest.mark.parametrize("mode", [0o666, 0o644, 0o640, 0o604, 0o620, 0o602, 0o610])
def test_key_accessible_to_others_is_refused(key, mode):
    key.chmod(mode)
    with pytest.raises(UsageError) as caught:
        read_private_key(key)
    assert f"accessible to others than its owner (mode {mode:04o})" in caught.value.message
    assert f"chmod 600 '{key}'" in caught.value.hint
    key.chmod(0o400)
    assert read_private_key(key)


def test_file_modes_are_ignored_on_windows(key, monkeypatch):
    key.chmod(0o666)
    monkeypatch.setattr("rigrunner.proof.keys.os.name", "nt")
    assert read_private_key(key)


def test_invalid_key_file_is_refused(tmp_path):
    (tmp_path / "text").write_text("hello")
    for read in (read_private_key, read_public_keys):
        with pytest.raises(UsageError, match=r"is not a private key|holds no public key"):
            read(tmp_path / "text")
        with pytest.raises(UsageError, match="cannot be read"):
            read(tmp_path / "nowhere")


@pytest.mark.skipif(shutil.which("openssl") is None, reason="needs openssl")
def test_openssl_agrees_on_fingerprint_and_signature(key, tmp_path):
    public = f"{key}.pub"
    der = subprocess.run(
        ["openssl", "pkey", "-pubin", "-in", public, "-outform", "DER"],
        capture_output=True,
        check=True,
    ).stdout
    (read,) = read_public_keys(key.with_name("lab.key.pub"))
    assert fingerprint(read) == f"SHA256:{hashlib.sha256(der).hexdigest()}"
    content = json.loads(signature_json(signed(key)))
    (tmp_path / "sig").write_bytes(base64.b64decode(content.pop("signature")))
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    (tmp_path / "text").write_text(text, encoding="ascii")
    openssl = subprocess.run(
        ["openssl", "pkeyutl", "-verify", "-pubin", "-inkey", public, "-rawin",
         "-in", tmp_path / "text", "-sigfile", tmp_path / "sig"],
        capture_output=True, check=False,
    )  # fmt: skip
    assert openssl.returncode == 0, openssl


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "signing needs a certificate, a key and a name"),
        (["x.json", "--key", "k"], "signing needs a certificate, a key and a name"),
        (["x.json", "--key", "k", "--by", "Z"], "there is no certificate x.json"),
        (["x.txt", "--key", "k", "--by", "Z"], "x.txt is not a certificate"),
        (["x.json", "--new-key", "k"], "signs nothing"),
    ],
)
def test_wrong_arguments_are_refused(words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = call("sign", *words)
    assert done.code == 2
    assert message in done.err


@pytest.mark.parametrize(
    ("member", "value", "message"),
    [
        ("format", "signature/9", "C-1.sig.json is not of the format"),
        ("signer", 7, "C-1.sig.json is not of the format"),
        ("files", ["C-1.json"], "C-1.sig.json: 'files' must hold a digest by file name"),
    ],
)
def test_signature_of_another_format_is_refused(key, member, value, message):
    document = json.loads(signature_json(signed(key))) | {member: value}
    with pytest.raises(DataError, match=message):
        parse_signature(json.dumps(document).encode(), "C-1.sig.json")
