"""Facts on a stored run, as JSON for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.runfile import RunInfo


LOST = "lost "
"""Prefix of the names of lost objects in the provenance of a salvaged run."""


def salvaged_lines(salvaged: Mapping[str, str]) -> list[str]:
    """Return the file from which a run was salvaged, and what is lost, one object a line."""
    if not salvaged:
        return []
    lost = {name: text for name, text in salvaged.items() if name.startswith(LOST)}
    first = f"salvaged from {salvaged.get('file')} (SHA-256 {salvaged.get('sha256')})"
    return [f"{first}; never to be certified", *(f"{name}: {text}" for name, text in lost.items())]


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
        **({"salvaged": dict(header.salvaged)} if header.salvaged else {}),
    }
