"""Approval of procedures: a procedure is a draft, or its text was approved by a person."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from rigrunner.api.errors import UsageError
from rigrunner.api.names import Identifier, Text
from rigrunner.api.settings import ListOf, Settings
from rigrunner.clock import utc_text
from rigrunner.run.locate import shipped_folder
from rigrunner.yamlfile import read, validate

if TYPE_CHECKING:
    from datetime import date, datetime

    from rigrunner.procedure import LoadedProcedure

SUFFIX = ".approval.json"
NOT_FOR_CERTIFICATION = "not for certification"

Digest = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class Approved(Settings):
    """Who approved a procedure, when, and which texts."""

    revision: Text
    """Revision of the procedure."""
    by: Text
    """Name of the person."""
    utc: Text
    """When: a date, or a time in UTC."""
    sha256: Digest
    """Of the procedure and all that it calls: `rigrunner.procedure.texts_digest`."""


class ApprovalFile(Settings):
    """The file beside a procedure with its approvals."""

    rigrunner: Literal["approval/1"]
    """Type and version of this file."""
    procedure: Identifier
    """The id of the procedure."""
    approved: Approved
    """The approval in force."""
    earlier: ListOf[Approved] = ()
    """Earlier ones, oldest first."""


@dataclass(frozen=True)
class ApprovalState:
    """Whether the present text of a procedure is approved."""

    state: Literal["draft", "approved"]
    by: str = ""
    utc: str = ""
    sha256: str = ""
    """Of the present texts, approved or not."""
    note: str = ""
    """Why it is a draft although an earlier text was approved."""

    @property
    def is_draft(self) -> bool:
        """Whether its results are not for certification."""
        return self.state == "draft"

    def texts(self) -> dict[str, str]:
        """Return the approval for the header of a run."""
        fields = ("state", "by", "utc", "sha256", "note")
        return {name: text for name in fields if (text := str(getattr(self, name)))}

    def sentence(self) -> str:
        """Return the approval as a sentence."""
        if self.state == "approved":
            return f"approved by {self.by} on {self.utc[:10]}"
        return f"draft, {NOT_FOR_CERTIFICATION}{f': {self.note}' if self.note else ''}"


def approval_file(procedure: Path) -> Path:
    """Return the path of the approval of a procedure, beside it."""
    return procedure.with_suffix(SUFFIX)


def approval_state(procedure: LoadedProcedure) -> ApprovalState:
    """Return the approval of a procedure; raise InvalidFileError if it cannot be read."""
    digest = procedure.digest_with_called
    file = _read(approval_file(Path(procedure.document.name)))
    if file is None:
        return ApprovalState("draft", sha256=digest)
    last = file.approved
    if last.sha256 == digest and file.procedure == procedure.model.id:
        return ApprovalState("approved", last.by, last.utc, digest)
    what = "the procedure, or one that it calls," if procedure.called else "the procedure"
    note = f"{what} was changed after its approval by {last.by} on {last.utc[:10]}"
    return ApprovalState("draft", sha256=digest, note=note)


def moment_of(day: date | None, now: datetime) -> str:
    """Return the given day, or else this moment in UTC; raise UsageError for a future day."""
    if day is None:
        return utc_text(now)
    if day > now.date():
        raise UsageError(f"{day} is in the future", hint="an approval is dated today or earlier")
    return day.isoformat()


def approve(procedure: LoadedProcedure, by: str, utc: str) -> Path:
    """Record that a person approves the present text of a procedure; return the file.

    Earlier approvals are kept. Raises UsageError without a name, for a shipped procedure, and if
    the file cannot be written; InvalidFileError for a broken file.
    """
    by, source = by.strip(), Path(procedure.document.name)
    if not by:
        raise UsageError("an approval needs a name", hint="such as --by 'A. Jones'")
    if source.resolve().is_relative_to(shipped_folder().resolve()):
        raise UsageError(
            f"{source.name} is shipped with Rigrunner: a laboratory approves a copy of its own",
            hint="'rigrunner init DIR' makes a lab folder with copies",
        )
    path = approval_file(source)
    previous = _read(path)
    content = {
        "rigrunner": "approval/1",
        "procedure": procedure.model.id,
        "approved": {
            "revision": procedure.model.revision,
            "by": by,
            "utc": utc,
            "sha256": procedure.digest_with_called,
        },
        "earlier": [approval.model_dump() for approval in (*previous.earlier, previous.approved)]
        if previous
        else [],
    }
    _write(path, json.dumps(content, ensure_ascii=False, indent=2) + "\n")
    return path


def approved_in(path: Path) -> Approved | None:
    """Return the approval in force in the file beside a procedure; None for none."""
    file = _read(path)
    return None if file is None else file.approved


def _read(path: Path) -> ApprovalFile | None:
    return validate(ApprovalFile, read(path)) if path.exists() else None


def _write(path: Path, text: str) -> None:
    """Replace the whole file at once."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.unlink(missing_ok=True)
        with part.open("x", encoding="utf-8") as file:  # a link put there is not followed
            file.write(text)
        part.replace(path)
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from error
