"""Checks that the files of a document agree: each intact, same content, pages that show it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.certificate import parse_certificate
from rigrunner.api.errors import DataError, MissingPackageError
from rigrunner.certificate.numbers import Numbers, prefix_of
from rigrunner.certificate.withdrawal import SUFFIX, read_withdrawal
from rigrunner.documents.verifying.forms import Form, paths_of
from rigrunner.documents.verifying.pages import check_page, page_maker
from rigrunner.proof.compare import mismatches
from rigrunner.proof.contents import content_in
from rigrunner.proof.places import place_in
from rigrunner.proof.seal import check_seal

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.documents.verifying.verification import Verification
    from rigrunner.registry import Registry

_DOCUMENT_NUMBER = re.compile(r"(?<![A-Za-z0-9])(?:SPECIMEN-)?[A-Za-z0-9]{1,16}-\d{4}-\d{4,}(?!\d)")
_LARGEST = 5_000_000
"""Largest JSON of a certificate that is searched for what it replaces, in bytes."""


@dataclass(frozen=True, eq=False)
class Document:
    """The forms of a document with their readable contents."""

    path: Path
    """Path of the named form."""
    forms: Sequence[Form]
    contents: Mapping[str, Certificate]
    """Contents by file name."""

    @property
    def first(self) -> str:
        """The file with which others are compared: the named one if readable."""
        return self.path.name if self.path.name in self.contents else next(iter(self.contents))

    @property
    def certificate(self) -> Certificate:
        """The content of the document."""
        return self.contents[self.first]


def read_forms(verification: Verification, path: Path) -> Iterator[Form]:
    """Yield the files of the document at a path; an unreadable one is a difference."""
    for file in paths_of(path):
        try:
            yield Form(file, file.read_bytes())
        except OSError as error:
            verification.differences.append(f"{file.name}: it cannot be read: {error.strerror}")


def read_contents(verification: Verification, forms: Sequence[Form]) -> dict[str, Certificate]:
    """Check the seals of all forms, and return the readable contents."""
    contents = {form.name: _content(verification, form) for form in forms}
    return {name: content for name, content in contents.items() if content is not None}


def _content(verification: Verification, form: Form) -> Certificate | None:
    verification.attempt(
        f"seal of {form.name}",
        lambda: (
            f"changed at {place_in(form.issued, form.suffix, part.start, part.end)}"
            for part in check_seal(form.issued, form.suffix)
        ),
    )
    try:
        return content_in(form.issued, form.suffix, form.name)
    except DataError as error:
        reason = error.message.removeprefix(f"{form.name} ")
        verification.differences.append(f"content of {form.name}: it {reason}")
        return None


def check_document(
    verification: Verification,
    document: Document,
    registry: Registry,
    letterhead: Path | None,
    *,
    signed: bool,
) -> None:
    """Check that all forms agree, that pages show their content, and the number.

    `signed`: a trusted key signed all of them.
    """
    certificate = document.certificate
    expected = certificate.model_dump(mode="json")
    for name, content in document.contents.items():
        if name != document.first:
            differences: list[object] = [*mismatches(expected, content.model_dump(mode="json"))]
            # The tolerance is for what is computed again. These were made of one content.
            if not differences and content != certificate:
                differences.append("its content differs by less than is printed")
            verification.take(f"content of {name} is that of {document.first}", differences)
    check_name(verification, document.path, certificate.number)
    maker = page_maker(verification, certificate, registry, letterhead)
    for form in document.forms:
        if form.suffix != ".json" and form.name in document.contents:
            check_page(verification, form, maker, signed=signed)
            _check_appended(verification, form)
    check_number(verification, document.forms, certificate, letterhead)


def _check_appended(verification: Verification, form: Form) -> None:
    """Check what was appended to a PDF after it was issued: a standard seal, or more."""
    if form.content == form.issued:
        return
    what = f"what was appended to {form.name} after it was issued"
    try:
        from rigrunner.proof.pdf_seals import additions_to  # noqa: PLC0415  (an extra)

        appended = additions_to(form.issued, form.content)
    except MissingPackageError as error:
        verification.unproven.append(f"{what} was not checked: {error}")
        return
    except DataError as error:
        verification.take(what, [error])
        return
    if verification.take(what, appended.changed):
        drawings = appended.drawn
        verification.unproven.extend(f"{each} may cover what was issued" for each in drawings)
        verification.information.append(
            f"{form.name} is as issued, plus a seal ({', '.join(appended.seals)}):"
            " a PDF reader shows who made it and whether it is valid"
        )


def check_name(verification: Verification, path: Path, number: str) -> None:
    """Compare the file name with the number of the document.

    The name of another document is a difference: a replacement could pass for the original. Any
    other name is information.
    """
    numbers = _DOCUMENT_NUMBER.findall(path.stem)
    if numbers and number not in numbers:
        verification.differences.append(
            f"name of {path.name}: the document in it is {number}, not {numbers[0]}"
        )
    elif path.stem != number:
        text = f"{path.name} is not the name as issued: the document is {number}"
        verification.information.append(text)


def check_number(
    verification: Verification,
    forms: Sequence[Form],
    certificate: Certificate,
    letterhead: Path | None,
) -> None:
    """Compare a document with the record of numbers, and report whether it is in force.

    It may be replaced or withdrawn, by that record or by a document in the same folder.
    """
    number, numbers = certificate.number, None
    if letterhead is not None:
        numbers = Numbers(letterhead, prefix_of(number))
        if numbers.kept:
            issued = numbers.digests_of(number)
            changed = [form.name for form in forms if not form.digests & issued]
            differences = [f"{name} is not as it was issued" for name in changed]
            if not issued:
                differences = [f"it was not issued under the letterhead in {letterhead}"]
            verification.take(f"record of {number}", differences)
        else:
            verification.information.append(
                f"{letterhead} has no record of numbers, so it was not checked"
            )
    if numbers and (withdrawal := numbers.withdrawal_of(number)):
        verification.withdrawn.append(f"{number} is no longer in force: {withdrawal}")
    elif notice := _notice_beside(forms, number):
        verification.withdrawn.append(f"{number} is no longer in force, as {notice}")
    if numbers and (new := numbers.replaced_by(number)):
        verification.replaced.append(f"{number} is no longer in force: {new} replaced it")
    elif new := _replacement_beside(forms, number):
        verification.replaced.append(f"{number} is no longer in force, as {new} beside it says")


def _notice_beside(forms: Sequence[Form], number: str) -> str:
    """Return what the notice in the same folder says that withdraws this document."""
    notice = forms[0].path.parent / f"{number}{SUFFIX}"
    withdrawal, digests = read_withdrawal(notice), _digests(forms)
    if not withdrawal:
        return ""
    # Another laboratory may have issued the same number. A damaged notice names no digest.
    is_other = withdrawal.sha256 and digests and withdrawal.sha256 not in digests
    return "" if is_other else f"{notice.name} beside it says: {withdrawal}"


def _digests(forms: Sequence[Form]) -> frozenset[str]:
    """Return the digests of the JSON, which documents on this one name; empty without it."""
    return frozenset().union(*(form.digests for form in forms if form.suffix == ".json"))


def _replacement_beside(forms: Sequence[Form], number: str) -> str:
    """Return the number of a document in the same folder that replaces this one."""
    digests = _digests(forms)
    own_paths = {form.path for form in forms}
    for path in sorted(forms[0].path.parent.glob("*.json")):
        candidate = _amends(path, number) if path not in own_paths else None
        if candidate and candidate.amends and (not digests or candidate.amends.sha256 in digests):
            return candidate.number
    return ""


def _amends(path: Path, number: str) -> Certificate | None:
    try:
        content = path.read_bytes() if path.stat().st_size <= _LARGEST else b""
        if number.encode() not in content:
            return None
        certificate = parse_certificate(content, path.name)
    except (OSError, DataError):  # what is no readable certificate replaces none
        return None
    return certificate if certificate.amends and certificate.amends.number == number else None
