"""Withdrawals: a document is no longer in force, although none replaces it (ISO/IEC 17025, 7.10).

The laboratory keeps the record of a withdrawal among its numbers; a copy of it, the notice, is
beside the document.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Literal

from pydantic import ValidationError

from rigrunner.api.certificate import Part, Sha256, Text

if TYPE_CHECKING:
    from pathlib import Path

SUFFIX = ".withdrawn.json"
_LONGEST = 1_000_000


class Withdrawal(Part):
    """Who withdrew a document, when and why."""

    rigrunner: Literal["withdrawal/1"] = "withdrawal/1"
    number: Text
    sha256: Sha256
    """SHA-256 of the JSON of the withdrawn document."""
    by: Text
    utc: Text
    reason: Text

    def __str__(self) -> str:
        """Return the withdrawal in one line."""
        text = f"withdrawn by {self.by} on {self.utc[:10]}: {self.reason}"
        return " ".join(text.split())


class UnreadableWithdrawal:
    """A withdrawal whose file is damaged."""

    sha256 = ""

    def __str__(self) -> str:
        """Return what is known of it."""
        return "withdrawn, but the record of it cannot be read"


def read_withdrawal(path: Path) -> Withdrawal | UnreadableWithdrawal | None:
    """Return the withdrawal in a file; None if there is no such file.

    A damaged file still withdraws: otherwise damage would put the document in force again.
    """
    if not os.path.lexists(path):  # pathlib's raises for a number that is no file name
        return None
    try:
        with path.open("rb") as file:
            return Withdrawal.model_validate_json(file.read(_LONGEST))
    except (OSError, ValidationError):
        return UnreadableWithdrawal()
