"""The content of a stored run."""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003  (read at run time, where records are checked)
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rigrunner.runfile.compressed import LongText

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigrunner.api.data import Measurement, Recording, ZeroReading
    from rigrunner.api.events import Event

FORMAT = 4
"""The version of the journal and of `run.h5`; newer ones are refused.

Version 2 added the manifest, version 3 the limits of measured values, version 4 the coordinates of
recordings and rows; the digest covers the last two. A run keeps the version with which it began,
which selects the algorithm of its digest.
"""


DRAFT: Mapping[str, str] = MappingProxyType({"state": "draft"})
"""The approval of a run without a stored one."""


@dataclass(frozen=True, kw_only=True)
class RunHeader:
    """What is known of a run before it begins; texts are stored verbatim."""

    run_id: str
    started_utc: str
    procedure_id: str
    procedure_revision: str
    procedure_title: str
    station_id: str
    procedure_text: str
    station_text: str
    plan_text: LongText = field(default_factory=LongText)
    called_texts: Mapping[str, str] = field(default_factory=dict)
    """The texts of called procedures, by file."""
    inputs: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, str] = field(default_factory=dict)
    """Versions of program, packages and plugins, identities of devices: name to text."""
    people: Mapping[str, str] = field(default_factory=dict)
    """People, by role: 'operator'."""
    approval: Mapping[str, str] = field(default_factory=lambda: dict(DRAFT))
    """The state of the procedure: 'state' is 'approved' or 'draft'; 'by', 'utc' and 'sha256' are
    those of the approval; 'note' is a remark. Older runs count as drafts."""
    imported: Mapping[str, str] = field(default_factory=dict)
    """For a run with recordings of another program: the 'program', the 'importer', 'utc'; 'by' is
    responsible for the 'mapping'; 'file NAME' is the SHA-256 of each. Else empty."""
    mapping_text: str = ""
    """Verbatim, the mapping of these files."""
    salvaged: Mapping[str, str] = field(default_factory=dict)
    """For a run that was salvaged from a damaged file: the 'file', its 'sha256', 'utc', 'by', and
    each lost object by its path, as 'lost /entry/...'. Else empty. Such a run is never
    certified."""
    files: Mapping[str, str] = field(default_factory=dict)
    """The paths of 'procedure' and 'station', and of each partner run by its name. Only a run that
    is not sealed keeps them, to be resumed: on another machine they mean nothing."""


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """The description of a stored run, without its samples."""

    path: Path
    """The file or folder of the run."""
    sealed: bool
    header: RunHeader
    """The header, with the answers that became inputs during the run."""
    ended_utc: str
    outcome: str
    """'completed', 'aborted' or 'error'; a run that never ended counts as 'error'."""
    reason: str
    recording_names: tuple[str, ...]
    """The finished recordings, in order."""
    digest: str
    """SHA-256 over finished recordings and measurements: it identifies the measured data."""
    format: int = FORMAT
    """The version of the layout, which selects the algorithm of the digest."""
    manifest_sha256: str = ""
    """SHA-256 of the text of the manifest, which has a digest of every object in the file.

    Empty without a manifest: in a run that is not sealed, or was sealed in format 1.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class StoredRun:
    """A complete stored run. The truth of a simulator is not part of it: see `read_truth`."""

    info: RunInfo
    recordings: tuple[Recording, ...]
    incomplete: tuple[Recording, ...]
    """The saved part of interrupted recordings."""
    superseded: tuple[Recording, ...] = ()
    """Good recordings of points that were repeated: stored, but not analysed."""
    zeros: Mapping[str, float]
    """The latest zero reading of each zeroed channel, in SI units."""
    recording_zeros: Mapping[str, Mapping[str, ZeroReading]] = field(default_factory=dict)
    """The zero readings in force during a recording, by its name."""
    measurements: tuple[Measurement, ...] = ()
    """The rows of its tables, in order, also those out of limits."""
    superseded_measurements: tuple[Measurement, ...] = ()
    """Rows of steps that were repeated: stored, but neither analysed nor judged."""
    events: Sequence[Event]
    outline: Sequence[Event]
    """The events but for points of scans, and steps that neither record nor take a zero."""
    result_document: Mapping[str, Any] | None
    """The first analysis, as in `result.json`."""
    partners: Mapping[str, StoredRun] = field(default_factory=dict)
    """The partner runs that the first analysis used, by name, as embedded in the sealed file."""
    notes: tuple[str, ...] = ()
    """Irregularities of the files, as text."""

    @property
    def header(self) -> RunHeader:
        """The data from before the run began."""
        return self.info.header

    @property
    def digest(self) -> str:
        """SHA-256 over finished recordings and measurements."""
        return self.info.digest

    @property
    def manifest_sha256(self) -> str:
        """SHA-256 of the manifest's text; empty in a run that has none."""
        return self.info.manifest_sha256
