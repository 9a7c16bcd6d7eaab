"""The letterhead of a laboratory: name, logo, language and templates."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.certificate import Certificate, Laboratory


@dataclass(frozen=True)
class Logo:
    """A picture with its alternative text."""

    content: bytes
    media_type: str
    text: str


@dataclass(frozen=True)
class Letterhead:
    """The folder of a laboratory, as data without code."""

    laboratory: Laboratory
    language: str
    """Language of documents, as a BCP 47 tag: 'en', 'de'."""
    prefix: str
    """Prefix of the numbers of certificates."""
    logo: Logo | None = None
    statements: tuple[str, ...] = ()
    """Statements of the laboratory on each certificate."""
    texts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Texts by language and key; they replace the shipped ones."""
    templates: Mapping[str, str] = field(default_factory=dict)
    """Templates by file name; they replace the shipped ones."""
    style: str = ""
    """CSS added to the shipped one."""
    files: Mapping[str, str] = field(default_factory=dict)
    """SHA-256 of every file that documents depend on, by name."""


@dataclass(frozen=True)
class CertificateInput:
    """The input of a certificate format."""

    certificate: Certificate
    letterhead: Letterhead
