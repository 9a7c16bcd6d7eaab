"""What the analysis of torque adds to a certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from rigrunner.api import DataError, Member
from rigrunner.api.certificate import (
    CertifiedDetails,
    Deviation,
    PointResult,
    RejectedCycle,
    Results,
    ValidityCondition,
)
from rigrunner.signal.numerals import finite, stated
from rigrunner.signal.rounding import printed
from rigrunner_bearings.api.measurand import Validity
from rigrunner_bearings.api.points import StartPoint, SwingPoint
from rigrunner_bearings.api.rig import rig_of, torque_instruments
from rigrunner_bearings.signal.peaks import mean_peak
from rigrunner_bearings.torque.channels import role_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Instrument, Rejection, RunData
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import TorqueDetails

_STATISTIC_DECIMALS = 3


def certified_torque(
    found: TorqueDetails, run: RunData, no_load_run: RunData | None
) -> CertifiedDetails:
    """Return its parts; raise DataError where the primary method gave no result."""
    runs = ((run, found.loaded), (no_load_run, found.no_load))
    quantity = found.compensations[found.primary].measurand if found.primary else ""
    channels = list(torque_instruments(run.instruments.values())) if found.loaded else []
    if _is_loaded(found):
        channels.append(_load_channel(run))
    load = [
        Deviation(kind="load", run_id=run.run_id, where=_load_channel(run), text=text)
        for text in (_load_problem(found, run),)
        if text
    ]
    return CertifiedDetails(
        results=_results(found, run),
        method=found.primary,
        quantity=quantity,
        validity=tuple(_validity(found)),
        channels=frozenset(channels),
        deviations=(*beyond_calibration(found, run, no_load_run), *load),
        rejected=tuple(
            each
            for one, points in runs
            if one is not None
            for point in points
            for each in _rejected(one.run_id, point)
        ),
    )


def _results(found: TorqueDetails, run: RunData) -> Results | None:
    """Return the results of the primary method; None where none was asked for."""
    if not found.primary:
        return None
    if found.headline is None:
        raise DataError(f"{run.run_id} has no result to certify: {found.problem}")
    points = found.compensations[found.primary].points
    return Results(
        headline=stated(found.headline, "the result"),
        motion="start" if any(isinstance(each, StartPoint) for each in found.loaded) else "swing",
        points=tuple(_point(each, found.loaded) for each in points),
    )


def _validity(found: TorqueDetails) -> Iterator[ValidityCondition]:
    """Yield on what the results are conditional, by the kind of their measurand."""
    if found.kind is None:
        return
    for code in found.kind.validity:
        allowed = found.support_allowance if code is Validity.SUPPORT_FRICTION else None
        text = "" if allowed is None else f"{printed(allowed[0], 1)} {allowed[1]}"
        yield ValidityCondition(code=code.value, allowance=text)


def beyond_calibration(
    found: TorqueDetails, run: RunData, no_load_run: RunData | None
) -> Iterator[Deviation]:
    """Yield each channel that exceeded its calibrated range, with how far, in words."""
    for one, points in ((run, found.loaded), (no_load_run, found.no_load)):
        if one is None or not (points or found.primary):
            continue
        ranges = [
            (instrument, *_extremes(points), "N·m")
            for instrument in torque_instruments(one.instruments.values()).values()
        ]
        cell = _load_cell(one)
        loads = [point.load_n for point in points if point.load_n > 0]
        if cell is not None and loads:
            ranges.append((cell, min(loads), max(loads), "N"))
        for instrument, lowest, highest, unit in ranges:
            if text := instrument.beyond_range(lowest, highest, unit):
                yield Deviation(
                    kind="range", run_id=one.run_id, where=instrument.channel, text=text
                )


def _load_problem(found: TorqueDetails, run: RunData) -> str:
    """Return in words why it is not known how well the load is known; '' where that is known."""
    if not _is_loaded(found):
        return ""
    cell, tolerance = _load_cell(run), rig_of(run).load_tolerance
    stated = "load_tolerance" in run.rig_keys
    assumed = f"±{100 * tolerance:.3g} %, " + ("as the station says" if stated else "by default")
    if cell is None:
        return f"no instrument for it is in the station's register; its error is taken as {assumed}"
    if not (cell.certificate or cell.calibration):
        return f"the register names no calibration certificate of {cell.name}"
    least = min(point.load_n for point in found.loaded if point.load_n > 0)
    if cell.limit_of_error(least) is None and not stated:
        return f"the register does not say how accurate {cell.name} is; it is taken as {assumed}"
    return ""


def _load_channel(run: RunData) -> str:
    """Return the channel of the load, 'role.load'."""
    torque = next(iter(torque_instruments(run.instruments.values())), "tester.torque")
    return Member(role_of(torque), "load")


def _is_loaded(found: TorqueDetails) -> bool:
    return any(point.load_n > 0 for point in found.loaded)


def _load_cell(run: RunData) -> Instrument | None:
    torque = next(iter(torque_instruments(run.instruments.values())), None)
    return None if torque is None else run.instruments.get(f"{role_of(torque)}.load")


def _extremes(points: Sequence[PeakPoint]) -> tuple[float, float]:
    """Return the least and the greatest torque of what was kept, in N·m; 0 is always within."""
    values = [0.0]
    for point in points:
        values.append(float(point.peak_nm[point.peak_kept].max(initial=0.0)))
        if isinstance(point, SwingPoint):
            kept = point.torque_nm[point.kept]
            values.extend((float(kept.min(initial=0.0)), float(kept.max(initial=0.0))))
    return min(values), max(values)


def _point(found: CompensatedPoint, recorded: Sequence[PeakPoint]) -> PointResult:
    # Its recording: the same set-point, the nearest in frequency.
    same = [each for each in recorded if each.set_frequency_hz == found.set_frequency_hz]
    point = min(same, key=lambda each: abs(each.frequency_hz.value - found.frequency_hz))
    torque = stated(found.torque, f"the result of {point.recording}")
    raw_nm = mean_peak(point).value
    peaks = int(point.peak_kept.sum())
    used = peaks if found.cycles_used is None else found.cycles_used
    return PointResult(
        recording=point.recording,
        set_frequency_hz=found.set_frequency_hz,
        frequency_hz=found.frequency_hz,
        load_n=point.load_n,
        cycles=point.cycles,
        cycles_rejected=point.cycles - used,
        raw_nm=raw_nm,
        printed_raw=printed(raw_nm, torque.decimals),
        torque=torque,
    )


def _rejected(run_id: str, point: PeakPoint) -> Iterator[RejectedCycle]:
    for each in point.peak_rejections:
        yield _cycle(run_id, point.recording, "peak", each)
    if isinstance(point, SwingPoint):
        for each in point.waveform_rejections:
            yield _cycle(run_id, point.recording, "waveform", each)


def _cycle(
    run_id: str, recording: str, what: Literal["peak", "waveform"], each: Rejection
) -> RejectedCycle:
    return RejectedCycle(
        run_id=run_id,
        recording=recording,
        cycle=each.index + 1,
        what=what,
        rule=each.rule,
        value_nm=finite(each.value),
        statistic=finite(each.statistic),
        critical=finite(each.critical),
        printed_statistic=printed(each.statistic, _STATISTIC_DECIMALS),
        printed_critical=printed(each.critical, _STATISTIC_DECIMALS),
    )
