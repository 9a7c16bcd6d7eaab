"""A letterhead folder: the laboratory's name, logo, language, texts and templates, without code.

letterhead.yaml      who the laboratory is; language, prefix of its numbers, logo
texts/<language>.yaml    fixed texts: some of a shipped language, or all of a new one
templates/*.j2       templates that go before the shipped ones
style.css            is added to the shipped style
numbers/             the numbers that were given: see `rigrunner.certificate.numbers`
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from rigrunner.api.certificate import Laboratory
from rigrunner.api.errors import InvalidFileError, Problem, UsageError
from rigrunner.api.letterhead import Letterhead, Logo
from rigrunner.api.names import Text
from rigrunner.api.settings import ListOf, PlainText, Settings
from rigrunner.yamlfile import read, validate
from rigrunner.yamlfile.reader import read_text

if TYPE_CHECKING:
    from pathlib import Path

FILE = "letterhead.yaml"
STYLE = "style.css"
MAX_LOGO_BYTES = 500_000
MEDIA_TYPES = {
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
}


class LaboratoryEntry(Settings):
    """The laboratory that issues the certificate."""

    name: Text
    """Registered name."""
    address: Annotated[ListOf[Text], Field(min_length=1)]
    """Address by line."""
    place: Text
    """Place of the tests: 'at the address above', or another one."""
    contact: PlainText = ""
    """Telephone, e-mail, web page."""
    accreditation: PlainText = ""
    """Statement of an accreditation; left out, there is none."""


class LogoEntry(Settings):
    """The laboratory's logo."""

    file: Text
    """File in the letterhead folder: .svg, .png or .jpg."""
    text: Text
    """Alternative text."""


class LetterheadFile(Settings):
    """The content of `letterhead.yaml`."""

    rigrunner: Literal["letterhead/1"]
    """Type and version of this file."""
    laboratory: LaboratoryEntry
    language: Annotated[str, Field(pattern=r"^[a-z]{2,3}(-[A-Z]{2})?$")] = "en"
    """Language of certificates: en and de are shipped; others need a file of texts here."""
    prefix: Annotated[str, Field(pattern=r"^[A-Za-z0-9]{1,16}$")]
    """Prefix of certificate numbers; two folders must not share one."""
    logo: LogoEntry | None = None
    statements: ListOf[Text] = ()
    """Statements on each certificate, in addition to those required by the standard."""


class TextsFile(Settings):
    """The content of `texts/<language>.yaml`."""

    rigrunner: Literal["texts/1"]
    """Type and version of this file."""
    texts: dict[str, str]
    """Texts by key; the keys are those of the shipped languages."""


def read_letterhead(folder: Path, language: str = "") -> Letterhead:
    """Return the letterhead in a folder, in its language or the given one.

    Raises UsageError if the folder does not exist and InvalidFileError with its problems.
    """
    path = folder / FILE
    if not path.is_file():
        raise UsageError(
            f"there is no letterhead in {folder}: no {FILE}",
            hint="'rigrunner init DIR' makes a lab folder with one; name it with --letterhead",
        )
    document = read(path)
    file = validate(LetterheadFile, document)
    texts, templates = _files(folder / "texts", "*.yaml"), _files(folder / "templates", "*.j2")
    style = [folder / STYLE] if (folder / STYLE).is_file() else []
    files = [path, *style, *templates, *texts]
    logo = None
    if file.logo is not None:
        picture = folder / file.logo.file
        media_type = MEDIA_TYPES.get(picture.suffix.lower(), "")
        problem = _logo_problem(folder, picture, media_type)
        if problem:
            where = document.where(("logo", "file"))
            raise InvalidFileError([Problem(problem, where, "logo.file")])
        logo = Logo(picture.read_bytes(), media_type, file.logo.text)
        files.insert(1, picture)
    return Letterhead(
        laboratory=Laboratory(**dict(file.laboratory)),
        language=language or file.language,
        prefix=file.prefix,
        logo=logo,
        statements=file.statements,
        texts={path.stem: validate(TextsFile, read(path)).texts for path in texts},
        templates={path.name: read_text(path) for path in templates},
        style="".join(map(read_text, style)),
        files={
            path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in files
        },
    )


def _files(folder: Path, pattern: str) -> list[Path]:
    return sorted(path for path in folder.glob(pattern) if path.is_file())


def _logo_problem(folder: Path, path: Path, media_type: str) -> str:
    if not media_type:
        return f"'{path.name}' is not a picture, expected {', '.join(MEDIA_TYPES)}"
    if not path.is_file():
        return f"there is no file {path}"
    if not path.resolve().is_relative_to(folder.resolve()):
        return f"{path} is outside the letterhead folder"
    if path.stat().st_size > MAX_LOGO_BYTES:
        return f"{path.name} is larger than {MAX_LOGO_BYTES:,} bytes"
    return ""
