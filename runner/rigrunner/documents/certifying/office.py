"""Take a number for a document and write its files. Nothing is ever overwritten."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.certificate import certificate_json
from rigrunner.api.errors import DataError, MissingPackageError, RigrunnerError
from rigrunner.api.hooks import CertificateFormatRecord
from rigrunner.api.letterhead import CertificateInput
from rigrunner.api.progress import unseen
from rigrunner.certificate.numbers import Numbers
from rigrunner.clock import utc_text
from rigrunner.proof.seal import FORMS, seal
from rigrunner.runfile.durable import cannot_write

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from datetime import datetime
    from pathlib import Path

    from rigrunner.api.certificate import Certificate
    from rigrunner.api.letterhead import Letterhead
    from rigrunner.api.progress import Progress
    from rigrunner.registry import Registry

KIND = "certificate_format"
MAKING = "making the pages"


@dataclass(frozen=True)
class Issued:
    """The files that were written."""

    certificate: Certificate
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    """Notes for the user: forms that could not be made, numbers that were interrupted."""


@dataclass(frozen=True, eq=False)
class Office:
    """Issues documents under a laboratory's letterhead."""

    folder: Path
    """The letterhead's folder, which holds the sequence of numbers."""
    letterhead: Letterhead
    registry: Registry
    now: datetime
    progress: Progress = unseen
    """Called with the number of forms made, and of all."""

    def issue(
        self, content: Callable[[str], Certificate], out: Path, *, is_specimen: bool
    ) -> Issued:
        """Write the document that `content` gives for a number, in every form, into a folder.

        The files are made before their number is taken, so that failures leave no number; they are
        made again if another process has taken that number meanwhile. Raises the errors of
        `content`, and DataError if the files cannot be written; then the number is void.
        """
        makers, notes = self._makers()
        numbers = Numbers.of(self.folder, self.letterhead, is_specimen=is_specimen)
        interrupted = [f"{n} was reserved, but not issued" for n in numbers.interrupted()]
        expected = numbers.next(self.now.year)
        certificate = content(expected)
        files = self._files(certificate, makers)
        number = numbers.reserve(self.now.year, self._reason(certificate))
        try:
            if number != expected:
                certificate = content(number)
                files = self._files(certificate, makers)
            paths = _write(out, number, files)
        # After any other error the number has no outcome, and the next document reports that.
        except (RigrunnerError, OSError) as error:
            numbers.void(number, str(error))
            raise
        sha256 = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}
        numbers.issued(number, {"folder": str(out), "sha256": sha256})
        return Issued(certificate, paths, (*notes, *interrupted))

    def _reason(self, certificate: Certificate) -> dict[str, str]:
        """Return who asked for the number of a document, when, and for which run."""
        reason = {
            "by": certificate.authorisation.by,
            "utc": utc_text(self.now),
            "run": certificate.evidence.run.run_id,
        }
        return reason | ({"amends": certificate.amends.number} if certificate.amends else {})

    def _files(
        self, certificate: Certificate, makers: Mapping[str, Callable[[CertificateInput], bytes]]
    ) -> dict[str, bytes]:
        """Return the content of each file of a document by its suffix, with its seal."""
        files = {".json": certificate_json(certificate).encode()}
        for done, (suffix, make) in enumerate(makers.items(), 1):
            files[suffix] = make(CertificateInput(certificate, self.letterhead))
            self.progress(MAKING, done, len(makers))
        for suffix in files.keys() & FORMS:  # a plugin's own form takes no seal
            files[suffix] = seal(files[suffix], suffix)
        return files

    def _makers(self) -> tuple[dict[str, Callable[[CertificateInput], bytes]], list[str]]:
        """Return the maker of each printed form by suffix, and why some cannot be made."""
        makers: dict[str, Callable[[CertificateInput], bytes]] = {}
        notes = []
        for name in self.registry.names(KIND):
            record = self.registry.find(KIND, name).record
            assert isinstance(record, CertificateFormatRecord)  # noqa: S101  (the kind says so)
            try:
                makers[record.suffix] = self.registry.make(KIND, name, {})
            except MissingPackageError as error:
                notes.append(f"no {record.suffix} was made: {error}")
        return makers, notes


def _write(folder: Path, number: str, files: Mapping[str, bytes]) -> tuple[Path, ...]:
    """Write new files, durably; nothing is ever overwritten."""
    paths = tuple(folder / f"{number}{suffix}" for suffix in files)
    created: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, content in zip(paths, files.values(), strict=True):
            with path.open("xb") as file:
                created.append(path)
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
    except OSError as error:
        # Only what was created here: a file that was there before stays.
        for path in created:
            path.unlink(missing_ok=True)
        raise DataError(
            f"the certificate cannot be written: {error.filename or folder}: {error.strerror}",
            hint=cannot_write(folder, error).hint,
        ) from error
    return paths
