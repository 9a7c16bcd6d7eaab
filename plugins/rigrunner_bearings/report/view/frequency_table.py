"""The table of all set-points: what was measured, and the result of each method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api import Estimate
from rigrunner.signal.coverage import expanded
from rigrunner.signal.rounding import places
from rigrunner_bearings.api.points import MotionSource, StartPoint
from rigrunner_bearings.report.view.points import error
from rigrunner_bearings.signal.swings import kept_cycles
from rigrunner_reports.numbers import fixed, plain, stated, with_sign

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_bearings.api.torque import TorqueDetails
    from rigrunner_bearings.report.view.points import SetPoint

MILLI = 1e3
MOST_PLACES = 4
DEFAULT_PLACES = 3
MISSING = "\N{EM DASH}"
OF_CYCLES = "mean of each cycle's largest sample"
OF_STARTS = "mean of the greatest torque in the first travel of each start from rest"


@dataclass(frozen=True)
class Cell:
    """One method at one set-point; `error` in mN·m where the truth is known."""

    interval: str
    error: str = ""


@dataclass(frozen=True)
class Row:
    """One set-point."""

    set_hz: str
    measured_hz: str
    raw: str
    rig: str
    cells: tuple[Cell, ...]
    truth: str
    peaks: str
    swings: str


@dataclass(frozen=True)
class FrequencyTable:
    """Header and rows; a method that is not applicable has its reason instead of a column."""

    methods: tuple[str, ...]
    measurands: tuple[tuple[str, str], ...]
    primary: str
    rows: tuple[Row, ...]
    raw_peak: str
    """What the raw peak is, in words."""
    simulated: bool
    excluded: tuple[tuple[str, str], ...]


def frequency_table(torque: TorqueDetails, points: Sequence[SetPoint]) -> FrequencyTable:
    """Return the table of a run, in the order of the recordings."""
    methods = [name for name, compensation in torque.compensations.items() if compensation.points]
    # As many decimals as the primary method's uncertainty justifies at every set-point.
    results = [p.by_method[torque.primary] for p in points if torque.primary in p.by_method]
    digits = min((_digits(result.torque) for result in results), default=DEFAULT_PLACES)
    return FrequencyTable(
        methods=tuple(methods),
        measurands=tuple((name, torque.compensations[name].measurand) for name in methods),
        primary=torque.primary,
        rows=tuple(_row(torque, methods, set_point, digits) for set_point in points),
        raw_peak=OF_STARTS if are_starts(torque) else OF_CYCLES,
        simulated=any(set_point.truth_nm is not None for set_point in points),
        excluded=tuple(
            (name, compensation.not_applicable or "it gave no points")
            for name, compensation in torque.compensations.items()
            if not compensation.points
        ),
    )


def are_starts(torque: TorqueDetails) -> bool:
    """Return whether the run is of starts from rest, which stand where cycles stand elsewhere."""
    return any(isinstance(point, StartPoint) for point in torque.loaded)


def _row(torque: TorqueDetails, methods: Sequence[str], set_point: SetPoint, digits: int) -> Row:
    primary = set_point.by_method.get(torque.primary)
    point, swing = set_point.point, set_point.swing
    peaks = len(set_point.kept_peaks_nm)
    raw = Estimate(set_point.raw_peak_nm, set_point.raw_peak_u_nm, peaks - 1.0)
    return Row(
        set_hz=plain(point.set_frequency_hz),
        measured_hz=MISSING
        if point.motion is MotionSource.ENTERED
        else fixed(point.frequency_hz.value, _digits(point.frequency_hz)),
        raw=fixed(set_point.raw_peak_nm, digits) if methods else stated(raw).interval,
        rig=fixed(primary.rig_nm, digits) if primary else MISSING,
        cells=tuple(_cell(torque, name, set_point) for name in methods),
        truth=MISSING if set_point.truth_nm is None else fixed(set_point.truth_nm, MOST_PLACES),
        peaks=_kept(peaks, point.cycles),
        swings=_kept(int(kept_cycles(swing).sum()), point.cycles) if swing else MISSING,
    )


def _cell(torque: TorqueDetails, name: str, set_point: SetPoint) -> Cell:
    result = set_point.by_method.get(name)
    if result is None:
        return Cell(MISSING)
    off = error(set_point, name, torque.compensations[name])
    return Cell(stated(result.torque).interval, "" if off is None else with_sign(MILLI * off, 1))


def _digits(estimate: Estimate) -> int:
    return min(places(expanded(estimate)), MOST_PLACES)


def _kept(kept: int, cycles: int) -> str:
    return f"{kept} / {cycles - kept}"
