"""The reference of a golden run: its result, in a file with which later results are compared."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, ValidationError

from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.settings import Settings
from rigrunner_fleet.golden.figures import (
    AtFrequency,
    Figure,
    checks,
    figures,
    frequencies,
    named_results,
    sources,
    verdicts,
)
from rigrunner_fleet.reanalysis.summary import write_text

if TYPE_CHECKING:
    from collections.abc import Mapping

REFERENCE = "reference.json"


class Snapshot(Settings):
    """The compared part of an analysis of a run."""

    problem: str = ""
    """Why there is no result, if so."""
    sha256: str = ""
    """SHA-256 of the whole result in its canonical form: keys sorted, no spaces."""
    method: str = ""
    """The primary method."""
    verdicts: dict[str, str] = Field(default_factory=dict)
    checks: dict[str, bool] = Field(default_factory=dict)
    sources: tuple[str, ...] = ()
    """The methods and fits."""
    figures: dict[str, Figure] = Field(default_factory=dict)
    frequencies: tuple[AtFrequency, ...] = ()
    results: tuple[str, ...] = ()
    """The figures that are named results."""

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Snapshot:
        """Return the compared part of a result document."""
        text = json.dumps(document, sort_keys=True, separators=(",", ":"))
        return cls(
            sha256=hashlib.sha256(text.encode()).hexdigest(),
            method=document["headline"]["method"] or "",
            verdicts=verdicts(document),
            checks=checks(document),
            sources=sources(document),
            figures=figures(document),
            frequencies=tuple(frequencies(document)),
            results=named_results(document),
        )

    @property
    def verdict(self) -> str:
        """The verdict on the run; '' without a decision."""
        return self.verdicts.get("run", "")


class Reference(Settings):
    """A golden run."""

    format: Literal["rigrunner: golden/1"] = "rigrunner: golden/1"
    name: str
    run: str
    """Its id."""
    at: str
    """The run folder or file, from the folder of the golden runs, with '/'."""
    digest_sha256: str
    """Digest of its recordings and measurements."""
    no_load_sha256: str = ""
    """Digest of those of the no-load run in the result."""
    made_by: dict[str, str]
    """Software with its versions, and changed settings, which made this result."""
    found: Snapshot

    def path(self, folder: Path) -> Path:
        """Return the path of the run."""
        return Path(os.path.normpath(folder / self.at))


def write_reference(folder: Path, reference: Reference) -> None:
    """Write a golden run's file, for people and version control: one number per line."""
    text = json.dumps(reference.model_dump(mode="json"), ensure_ascii=False, indent=1)
    write_text(folder / reference.name / REFERENCE, f"{text}\n")


def read_references(folder: Path) -> list[Reference]:
    """Return the golden runs of a folder by name; raise UsageError without any, and DataError."""
    files = sorted(folder.rglob(REFERENCE)) if folder.is_dir() else []
    if not files:
        raise UsageError(
            f"there is no golden run in {folder}",
            hint="'rigrunner golden record RUNS --out FOLDER' makes them",
        )
    return sorted(map(_read, files), key=lambda reference: reference.name)


def _read(file: Path) -> Reference:
    try:
        return Reference.model_validate_json(file.read_bytes())
    except OSError as error:
        raise DataError(f"{file} cannot be read: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the file"
        raise DataError(
            f"{file} is not a reference of a golden run: {where}: {first['msg']}",
            hint="'rigrunner golden record' makes it again",
        ) from error
