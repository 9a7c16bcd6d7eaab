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
    wanted = _named(result) or {each.channel for each in instruments}
    entering = [each for each in instruments if each.channel in wanted]
    papers = tuple(
        dict.fromkeys(
            each.certificate
            for each in entering
            if each.certificate and each.calibration == "calibrated" and not each.overdue
        )
    )
    known = {each.channel for each in entering if each.certificate in papers}
    claimed = bool(papers) and known == wanted
    return Traceability(claimed=claimed, certificates=papers if claimed else ())


def not_calibrated(result: Result) -> Iterator[Deviation]:
    """Yield each channel that exceeded its calibrated range, or lacks data."""
    for each in certified_of(result):
        yield from each.deviations
    # No analysis says which instruments enter: all recorded or measured values of each count.
    if not _named(result):
        run_id = result.run.run_id
        for name, text in result.beyond.items():
            yield Deviation(kind="range", run_id=run_id, where=name, text=text)


def _named(result: Result) -> frozenset[str]:
    return frozenset[str]().union(*(each.channels for each in certified_of(result)))
