"""What a laboratory puts around a certificate: who it is, its logo, language and templates."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.certificate import Certificate, Laboratory


@dataclass(frozen=True)
class Logo:
    """A picture with the text that stands for it."""

    content: bytes
    media_type: str
    text: str


@dataclass(frozen=True)
class Letterhead:
    """A laboratory's folder, read; it holds data only, no code."""

    laboratory: Laboratory
    language: str
    """Of documents, as a tag of BCP 47: 'en', 'de'."""
    prefix: str
    """What the laboratory's numbers begin with."""
    logo: Logo | None = None
    statements: tuple[str, ...] = ()
    """What the laboratory says on each certificate besides."""
    texts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Fixed texts by language and key; they go before the shipped ones."""
    templates: Mapping[str, str] = field(default_factory=dict)
    """Templates by file name; they go before the shipped ones."""
    style: str = ""
    """CSS that is added to the shipped one."""
    files: Mapping[str, str] = field(default_factory=dict)
    """SHA-256 of every file that the documents depend on, by name."""


@dataclass(frozen=True)
class CertificateInput:
    """What a certificate format is given."""

    certificate: Certificate
    letterhead: Letterhead
