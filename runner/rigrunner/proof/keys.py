"""Ed25519 keys in PEM files: the private one in PKCS #8, the public one beside it."""

from __future__ import annotations

import hashlib
import os
import re
import stat
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, MissingPackageError, UsageError

try:
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives import serialization as pem
    from cryptography.hazmat.primitives.asymmetric.ed25519 import (
        Ed25519PrivateKey,
        Ed25519PublicKey,
    )
except ImportError as error:
    raise MissingPackageError(
        "signatures need the package 'cryptography', which is not installed",
        hint="pip install 'rigrunner[sign]'",
    ) from error

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

PRIVATE_MODE = 0o600
OTHERS = 0o077
"""Permissions that a private key must not have: all of its group and of others."""
_PUBLIC_BLOCK = re.compile(rb"-----BEGIN PUBLIC KEY-----[^-]*-----END PUBLIC KEY-----\s*")


def new_key(path: Path, passphrase: str = "") -> Path:
    """Make a key: `path` is the private one, readable by its owner only; return the public one's.

    Raises UsageError if one of the files exists or cannot be written.
    """
    key = Ed25519PrivateKey.generate()
    public = public_path(path)
    if public.exists():
        raise UsageError(f"{public} exists", hint="keys are never overwritten")
    secret = passphrase.encode()
    encryption = pem.BestAvailableEncryption(secret) if secret else pem.NoEncryption()
    _write_new(
        path,
        key.private_bytes(pem.Encoding.PEM, pem.PrivateFormat.PKCS8, encryption),
        PRIVATE_MODE,
    )
    _write_new(public, public_pem(key.public_key()).encode(), 0o644)
    return public


def public_path(private: Path) -> Path:
    """Return the path of the public key of a private key."""
    return private.with_name(f"{private.name}.pub")


def read_private_key(path: Path, passphrase: str = "") -> Ed25519PrivateKey:
    """Return the key in a file; raise UsageError for another file or a wrong passphrase.

    A file that other users can read or change is refused; not on Windows, whose mode does not tell.
    """
    with _readable(path), path.open("rb") as file:
        mode = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
        content = file.read()
    try:
        key = pem.load_pem_private_key(content, passphrase.encode() or None)
    except TypeError as error:  # cryptography's for a passphrase that is missing, or one too many
        state = "has no passphrase" if passphrase else "is protected by a passphrase"
        raise UsageError(f"the key {path} {state}") from error
    except (ValueError, UnsupportedAlgorithm) as error:
        why = "or the passphrase is wrong" if passphrase else "in PEM"
        raise UsageError(f"{path} is not a private key, {why}") from error
    if not isinstance(key, Ed25519PrivateKey):
        raise UsageError(f"{path} is a key, but not for Ed25519")
    if os.name != "nt" and mode & OTHERS:
        raise UsageError(
            f"the key {path} is accessible to others than its owner (mode {mode:04o})",
            hint=f"chmod 600 '{path}'; if others could have copied it, make a new key: --new-key",
        )
    return key


def read_public_keys(path: Path) -> list[Ed25519PublicKey]:
    """Return the public keys in a PEM file; raise UsageError."""
    with _readable(path):
        content = path.read_bytes()
    keys = [public_key_from(block, str(path)) for block in _PUBLIC_BLOCK.findall(content)]
    if not keys:
        raise UsageError(f"{path} holds no public key", hint="it has '-----BEGIN PUBLIC KEY-----'")
    return keys


def public_key_from(content: bytes, name: str) -> Ed25519PublicKey:
    """Return the public key in a PEM text; raise DataError with its place."""
    try:
        key = pem.load_pem_public_key(content)
    except (ValueError, UnsupportedAlgorithm) as error:
        raise DataError(f"{name} cannot be read: it is not a public key in PEM") from error
    if not isinstance(key, Ed25519PublicKey):
        raise DataError(f"{name} is a key, but not for Ed25519")
    return key


def public_pem(key: Ed25519PublicKey) -> str:
    """Return a public key as PEM."""
    form = pem.PublicFormat.SubjectPublicKeyInfo
    return key.public_bytes(pem.Encoding.PEM, form).decode()


def fingerprint(key: Ed25519PublicKey) -> str:
    """Return the SHA-256 of the key's DER form (SubjectPublicKeyInfo), as 'SHA256:…'."""
    form = pem.PublicFormat.SubjectPublicKeyInfo
    return f"SHA256:{hashlib.sha256(key.public_bytes(pem.Encoding.DER, form)).hexdigest()}"


def _write_new(path: Path, content: bytes, mode: int) -> None:
    try:
        # Made with its mode: a key is never open to others, not even until a chmod.
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
            file.write(content)
    except FileExistsError as error:
        raise UsageError(f"{path} exists", hint="keys are never overwritten") from error
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from error


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UsageError(f"the key {path} cannot be read: {error.strerror}") from error
