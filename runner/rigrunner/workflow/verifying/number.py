"""Whether the laboratory's own record knows a document as it is, and whether it is in force."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from rigrunner.certificate.numbers import Numbers, prefix_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from rigrunner.workflow.verifying.verification import Verification


def check_number(found: Verification, forms: Iterable[Path], number: str, letterhead: Path) -> None:
    """Compare every form of a document with the sequence of numbers in the letterhead's folder.

    A document that was replaced still is what was issued: that is told, and is no difference.
    """
    numbers = Numbers(letterhead, prefix_of(number))
    if not numbers.kept:
        found.information.append(f"{letterhead} keeps no numbers: the record was not looked at")
        return
    found.take(f"record of {number}", _differs(numbers, number, forms))
    replaced = numbers.replaced_by(number)
    if replaced:
        found.information.append(f"{number} is no longer in force: {replaced} replaced it")


def _differs(numbers: Numbers, number: str, forms: Iterable[Path]) -> Iterator[str]:
    digests = numbers.digests_of(number)
    if not digests:
        yield f"it was not issued under the letterhead in {numbers.letterhead}"
        return
    for form in forms:
        if hashlib.sha256(form.read_bytes()).hexdigest() not in digests:
            yield f"{form.name} is not as it was issued"
