"""Checks that a document belongs to its number, and that it is in force."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rigrunner.api.certificate import parse_certificate
from rigrunner.api.errors import DataError
from rigrunner.certificate.numbers import Numbers, prefix_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.documents.verifying.forms import Form
    from rigrunner.documents.verifying.verification import Verification


_LIKE_A_NUMBER = re.compile(r"(?<![A-Za-z0-9])(?:SPECIMEN-)?[A-Za-z0-9]{1,16}-\d{4}-\d{4,}(?!\d)")
_LARGEST = 5_000_000
"""Largest JSON of a certificate that is searched for what it replaces, in bytes."""


def check_name(found: Verification, path: Path, number: str) -> None:
    """Compare the file name with the number of the document.

    The name of another document is a difference: a replacement could pass for the original. Any
    other name is information.
    """
    named = _LIKE_A_NUMBER.findall(path.stem)
    if named and number not in named:
        found.differences.append(
            f"name of {path.name}: the document in it is {number}, not {named[0]}"
        )
    elif path.stem != number:
        found.information.append(f"{path.name} is a file name of its own: the document is {number}")


def check_number(
    found: Verification, forms: Sequence[Form], certificate: Certificate, letterhead: Path | None
) -> None:
    """Compare a document with the record of numbers, and report whether it was replaced.

    Without the folder of the laboratory, documents in the same folder are searched.
    """
    number, numbers = certificate.number, None
    if letterhead is not None:
        numbers = Numbers(letterhead, prefix_of(number))
        if numbers.kept:
            found.take(f"record of {number}", _differs(numbers, number, forms))
        else:
            found.information.append(f"{letterhead} keeps no numbers: the record was not looked at")
    other = numbers.replaced_by(number) if numbers else ""
    beside = "" if other else _replaced_beside(forms, number)
    if other:
        found.replaced.append(f"{number} is no longer in force: {other} replaced it")
    elif beside:
        found.replaced.append(f"{number} is no longer in force, as {beside} beside it says")


def _differs(numbers: Numbers, number: str, forms: Iterable[Form]) -> Iterator[str]:
    digests = numbers.digests_of(number)
    if not digests:
        yield f"it was not issued under the letterhead in {numbers.letterhead}"
        return
    for form in forms:
        if not form.digests & digests:
            yield f"{form.name} is not as it was issued"


def _replaced_beside(forms: Sequence[Form], number: str) -> str:
    """Return the number of a document in the same folder that replaces this one."""
    digests = frozenset().union(*(form.digests for form in forms if form.suffix == ".json"))
    own = {form.path for form in forms}
    for path in sorted(forms[0].path.parent.glob("*.json")):
        other = _amends(path, number) if path not in own else None
        if other and other.amends and (not digests or other.amends.sha256 in digests):
            return other.number
    return ""


def _amends(path: Path, number: str) -> Certificate | None:
    try:
        content = path.read_bytes() if path.stat().st_size <= _LARGEST else b""
        if number.encode() not in content:
            return None
        found = parse_certificate(content, path.name)
    except (OSError, DataError):
        return None
    return found if found.amends and found.amends.number == number else None
