"""What a stored run holds."""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003  (read at run time, where records are checked)
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.api.data import Measurement, Recording
    from rigrunner.api.events import Event

FORMAT = 4
"""The version of the journal and of `run.h5`; a reader refuses a newer one.

Version 2 added the manifest; version 3 limits of measured values, version 4
coordinates of recordings and rows: the digest covers both. A run
keeps the version with which it began: the algorithm of its digest goes by it."""


DRAFT: Mapping[str, str] = MappingProxyType({"state": "draft"})
"""The approval of a run of which nothing else is known."""


@dataclass(frozen=True, kw_only=True)
class RunHeader:
    """What is known of a run before it begins; texts are kept verbatim."""

    run_id: str
    started_utc: str
    procedure_id: str
    procedure_revision: str
    procedure_title: str
    station_id: str
    procedure_text: str
    station_text: str
    plan_text: str = ""
    called_texts: Mapping[str, str] = field(default_factory=dict)
    """The procedures that were called, by file."""
    inputs: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, str] = field(default_factory=dict)
    """Versions of program, packages and plugins, identities of devices: name to text."""
    people: Mapping[str, str] = field(default_factory=dict)
    """Who did what, by role: 'operator'."""
    approval: Mapping[str, str] = field(default_factory=lambda: dict(DRAFT))
    """The state of the procedure: 'state' is 'approved' or 'draft', 'by' and 'utc' say by whom and
    when, 'sha256' of which texts, 'note' what is to be said of it. Older runs count as drafts."""
    imported: Mapping[str, str] = field(default_factory=dict)
    """Of a run whose recordings another program made: by which 'program', read by which 'importer',
    at 'utc'; 'by' answers for the 'mapping'; 'file NAME' is the SHA-256 of each. Else empty."""
    mapping_text: str = ""
    """Verbatim, what said where the recordings stood in these files."""
    salvaged: Mapping[str, str] = field(default_factory=dict)
    """Of a run that was saved from a damaged file: the 'file', its 'sha256', 'utc', 'by' whom, and
    what is lost by its place, as 'lost /entry/...'. Else empty. Such a run is never certified."""
    files: Mapping[str, str] = field(default_factory=dict)
    """From where 'procedure' and 'station' were taken, and each partner run by its name. Only a
    run that is not sealed keeps it for resuming: it means nothing on another machine."""


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """What is known of a stored run without reading a sample."""

    path: Path
    """The file or folder that it was read from."""
    sealed: bool
    header: RunHeader
    """With the answers that became inputs while it ran."""
    ended_utc: str
    outcome: str
    """'completed', 'aborted' or 'error'; a run that never ended counts as 'error'."""
    reason: str
    recording_names: tuple[str, ...]
    """The finished recordings, in the order in which they were made."""
    digest: str
    """SHA-256 over finished recordings and measurements: the identity of what was measured."""
    format: int = FORMAT
    """The version of the layout, by which the algorithm of the digest goes."""
    manifest_sha256: str = ""
    """SHA-256 of the manifest's text, which holds a digest of all that is in the file.

    Empty where there is no manifest: in a run that is not sealed, or was sealed in format 1.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredRun:
    """A run read back whole. The truth of a simulator is not in it: see `read_truth`."""

    info: RunInfo
    recordings: tuple[Recording, ...]
    incomplete: tuple[Recording, ...]
    """What was saved of recordings that were interrupted."""
    superseded: tuple[Recording, ...] = ()
    """Good recordings of points that were repeated: kept, but no analysis uses them."""
    zeros: Mapping[str, float]
    """The latest zero reading of each zeroed channel, in SI units."""
    recording_zeros: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """The zero readings in force when a recording was made, by its name."""
    measurements: tuple[Measurement, ...] = ()
    """The rows of its tables, in order, those out of limits included."""
    superseded_measurements: tuple[Measurement, ...] = ()
    """Rows of steps that were repeated: kept, but neither analysed nor judged."""
    events: tuple[Event, ...]
    result_document: Mapping[str, Any] | None
    """The first analysis, as in `result.json`."""
    partners: Mapping[str, StoredRun] = field(default_factory=dict)
    """The partner runs that the first analysis used, by name, as embedded in the sealed file."""
    notes: tuple[str, ...] = ()
    """What is odd about the files, in words."""

    @property
    def header(self) -> RunHeader:
        """What was known before the run began."""
        return self.info.header

    @property
    def digest(self) -> str:
        """SHA-256 over finished recordings and measurements."""
        return self.info.digest

    @property
    def manifest_sha256(self) -> str:
        """SHA-256 of the manifest's text; empty in a run that has none."""
        return self.info.manifest_sha256
