"""Calibrations behind the results, and readings beyond their ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import Deviation, Traceability
from rigrunner.certificate.results import certified_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.certificate import InstrumentEntry
    from rigrunner.api.results import Result


def traceability_of(result: Result, instruments: Sequence[InstrumentEntry]) -> Traceability:
    """Return whether all calibrations behind the results are recorded, and which they are.

    Those named by the analyses; all if none names any.
    """
    channels = _channels(result) or {entry.channel for entry in instruments}
    entries = [entry for entry in instruments if entry.channel in channels]
    certificates = tuple(
        dict.fromkeys(
            entry.certificate
            for entry in entries
            if entry.certificate and entry.calibration == "calibrated" and not entry.overdue
        )
    )
    traceable = {entry.channel for entry in entries if entry.certificate in certificates}
    claimed = bool(certificates) and traceable == channels
    return Traceability(claimed=claimed, certificates=certificates if claimed else ())


def not_calibrated(result: Result) -> Iterator[Deviation]:
    """Yield each channel that exceeded its calibrated range, or lacks data."""
    for part in certified_of(result):
        yield from part.deviations
    # No analysis states which instruments its results depend on: all values of each count.
    if not _channels(result):
        run_id = result.run.run_id
        for name, text in result.beyond.items():
            yield Deviation(kind="range", run_id=run_id, where=name, text=text)


def _channels(result: Result) -> frozenset[str]:
    return frozenset[str]().union(*(part.channels for part in certified_of(result)))
