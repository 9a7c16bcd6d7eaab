"""The numbers of certificates: a sequence per laboratory, in which none is used twice.

Each number is a file of its own in the letterhead's folder `numbers/`. It is created exclusively,
which file systems grant to one process only, before anything is written under that number. What
became of the number is in further files beside it:

    RR-2026-0007.json            who requested it, when, for which run
    RR-2026-0007.issued.json     the files that were written under it, with their SHA-256
    RR-2026-0007.void.json       why nothing was
    RR-2026-0007.withdrawn.json  who withdrew the document, when and why

So each gap in the sequence has its explanation: a number without outcome was interrupted by a
crash.
"""

from __future__ import annotations

import json
import os
import re
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.certificate.withdrawal import SUFFIX, read_withdrawal
from rigrunner.runfile.durable import sync_folder

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.api.letterhead import Letterhead
    from rigrunner.certificate.withdrawal import UnreadableWithdrawal, Withdrawal

FOLDER = "numbers"
SPECIMEN = "SPECIMEN"
"""Prefix of documents that are not certificates, with their own sequence."""


@dataclass(frozen=True)
class Numbers:
    """The sequence of one prefix in the folder of a letterhead."""

    letterhead: Path
    prefix: str

    @classmethod
    def of(cls, folder: Path, letterhead: Letterhead, *, is_specimen: bool) -> Numbers:
        """Return the sequence of a letterhead's certificates, or that of its specimens."""
        prefix = letterhead.prefix
        return cls(folder, f"{SPECIMEN}-{prefix}" if is_specimen else prefix)

    def reserve(self, year: int, details: Mapping[str, str]) -> str:
        """Take the next number of a year permanently, and return it; `details` is stored with it.

        Raises DataError if the folder cannot be written.
        """
        for number in self._free(year):
            try:
                self._write(f"{number}.json", {"number": number, **details})
            except FileExistsError:  # another process has just taken it
                continue
            return number
        raise AssertionError  # there is always a free one

    def next(self, year: int) -> str:
        """Return the number that `reserve` takes, unless another process takes it first."""
        return next(self._free(year))

    def issued(self, number: str, details: Mapping[str, object]) -> None:
        """Record what was written under a number."""
        self._write(f"{number}.issued.json", {"number": number, **details})

    def void(self, number: str, reason: str) -> None:
        """Record why nothing was written under a number."""
        self._write(f"{number}.void.json", {"number": number, "reason": reason})

    def withdraw(self, withdrawal: Withdrawal) -> Path:
        """Record a withdrawal, and return the record's file.

        Raises FileExistsError if the document is withdrawn already.
        """
        number = withdrawal.number
        return self._write(f"{number}{SUFFIX}", withdrawal.model_dump(mode="json"))

    @property
    def kept(self) -> bool:
        """Whether this folder holds numbers; a copy of the letterhead need not."""
        return self._folder.is_dir()

    def interrupted(self) -> list[str]:
        """Return the numbers without a record of their outcome."""
        names = {path.name for path in self._folder.glob(f"{self.prefix}-*.json")}
        numbers = [name.removesuffix(".json") for name in names if name.count(".") == 1]
        return [
            number
            for number in sorted(numbers, key=_order)
            if not {f"{number}.issued.json", f"{number}.void.json"} & names
        ]

    def digests_of(self, number: str) -> set[str]:
        """Return the SHA-256 of the files issued under a number; empty for none."""
        digests = self._content(f"{number}.issued.json").get("sha256", {})
        values = digests.values() if isinstance(digests, dict) else ()
        return {digest for digest in values if isinstance(digest, str)}

    def replaced_by(self, number: str) -> str:
        """Return the number that replaces another; empty for none."""
        numbers = (newer for newer, record in self._issued() if record.get("amends") == number)
        return next(numbers, "")

    def withdrawal_of(self, number: str) -> Withdrawal | UnreadableWithdrawal | None:
        """Return the withdrawal of a number; None if it was not withdrawn."""
        return read_withdrawal(self._folder / f"{number}{SUFFIX}")

    def in_force_for(self, run_id: str) -> str:
        """Return the number in force for a run; empty for none."""
        numbers = (number for number in self._last_for(run_id) if not self.withdrawal_of(number))
        return next(numbers, "")

    def withdrawn_for(self, run_id: str) -> str:
        """Return the number on a run that was withdrawn and not replaced; empty for none."""
        return next(filter(self.withdrawal_of, self._last_for(run_id)), "")

    def _last_for(self, run_id: str) -> Iterator[str]:
        """Yield the issued numbers on a run that none replaces."""
        issued = {number: each for number, each in self._issued() if each.get("run") == run_id}
        replaced = {record.get("amends") for record in issued.values()}
        yield from (number for number in issued if number not in replaced)

    def _free(self, year: int) -> Iterator[str]:
        """Yield the numbers that follow those taken in a year, without end."""
        stem = f"{self.prefix}-{year}-"
        names = (path.name.removeprefix(stem) for path in self._folder.glob(f"{stem}*.json"))
        taken = [int(digits[0]) for name in names if (digits := re.match(r"\d+", name))]
        for sequence in count(max(taken, default=0) + 1):
            yield f"{stem}{sequence:04d}"

    def _issued(self) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield every issued number in order, with its record."""
        paths = self._folder.glob(f"{self.prefix}-*.issued.json")
        for number in sorted(
            (path.name.removesuffix(".issued.json") for path in paths), key=_order
        ):
            yield number, self._content(f"{number}.json")

    def _content(self, name: str) -> Mapping[str, object]:
        """Return the content of a file; empty for a missing or incomplete one."""
        try:
            content = json.loads((self._folder / name).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return {}
        return content if isinstance(content, dict) else {}

    @property
    def _folder(self) -> Path:
        return self.letterhead / FOLDER

    def _write(self, name: str, content: Mapping[str, object]) -> Path:
        """Write a new file durably, and return it; raise FileExistsError if it exists."""
        path = self._folder / name
        with _explained(self._folder):
            self._folder.mkdir(exist_ok=True)
        with _explained(path, FileExistsError):
            with path.open("x", encoding="utf-8") as file:
                json.dump(content, file, ensure_ascii=False, indent=1)
                file.write("\n")
                file.flush()
                os.fsync(file.fileno())
            sync_folder(self._folder)
        return path


def _order(number: str) -> tuple[str, int, str]:
    """Return the sort key of numbers in sequence: as texts, 10000 would come before 9999."""
    stem, _, sequence = number.rpartition("-")
    return stem, len(sequence), sequence


def prefix_of(number: str) -> str:
    """Return the prefix of a number, PREFIX-YEAR-SEQUENCE."""
    return number.rpartition("-")[0].rpartition("-")[0]


@contextmanager
def _explained(path: Path, *passed: type[OSError]) -> Iterator[None]:
    try:
        yield
    except passed:
        raise
    except OSError as error:
        raise DataError(
            f"cannot keep the number in {path}: {error.strerror or error}",
            hint="the letterhead's folder must be writable: it holds the sequence of numbers",
        ) from error
