"""What is known of a stored run, for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rigrunner.runfile import RunInfo


def info_document(info: RunInfo) -> dict[str, Any]:
    """Return identity, end and content of a stored run as JSON values."""
    header = info.header
    return {
        "run": header.run_id,
        "path": str(info.path),
        "procedure": {
            "id": header.procedure_id,
            "revision": header.procedure_revision,
            "title": header.procedure_title,
        },
        "station": header.station_id,
        "started_utc": header.started_utc,
        "ended_utc": info.ended_utc,
        "outcome": info.outcome,
        "reason": info.reason,
        "sealed": info.sealed,
        "inputs": dict(header.inputs),
        "recordings": list(info.recording_names),
        "digest_sha256": info.digest,
    }
