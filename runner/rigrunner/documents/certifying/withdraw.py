"""Withdraw an issued certificate, for which there is no replacement; its files stay as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, UsageError
from rigrunner.certificate.numbers import FOLDER
from rigrunner.certificate.withdrawal import SUFFIX, Withdrawal
from rigrunner.clock import utc_text
from rigrunner.documents.certifying.original import read_original
from rigrunner.runfile.durable import sync_file

if TYPE_CHECKING:
    from datetime import datetime
    from pathlib import Path


def withdraw(path: Path, letterhead: Path, *, by: str, reason: str, now: datetime) -> Path:
    """Record that the certificate at a path is withdrawn; return the notice beside it.

    The record is permanent: no command removes it. `by` is the name of the person who withdraws.
    Raises UsageError if name or reason is missing, or the certificate is not on record, replaced or
    withdrawn, and DataError if it is not as issued, or record or notice cannot be written.
    """
    if not reason.strip():
        raise UsageError("a withdrawal needs its --reason", field="reason")
    if not by.strip():
        raise UsageError("a withdrawal needs the name of the person who withdraws", field="by")
    original = read_original(path, letterhead)
    number = original.certificate.number
    withdrawal = Withdrawal(
        number=number,
        sha256=original.sha256,
        by=by.strip(),
        utc=utc_text(now),
        reason=reason.strip(),
    )
    try:
        record = original.numbers.withdraw(withdrawal)
    except FileExistsError as error:
        earlier = original.numbers.withdrawal_of(number)
        raise UsageError(
            f"{number} was already {earlier}", hint=f"it is on record in {letterhead / FOLDER}"
        ) from error
    notice = original.file.with_name(f"{number}{SUFFIX}")
    try:
        with notice.open("xb") as file:
            file.write(record.read_bytes())
        sync_file(notice)
    except OSError as error:
        raise DataError(
            f"{number} is withdrawn, but {notice} cannot be written: {error.strerror}",
            hint=f"copy {record} there",
        ) from error
    return notice
