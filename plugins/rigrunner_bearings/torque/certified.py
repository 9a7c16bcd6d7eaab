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
from rigrunner_bearings.torque.calibrated_range import beyond_calibration, load_cell
from rigrunner_bearings.torque.channels import role_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import Rejection, RunData
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.torque import TorqueDetails

_STATISTIC_DECIMALS = 3


def certified_torque(
    details: TorqueDetails, run: RunData, no_load_run: RunData | None
) -> CertifiedDetails:
    """Return its parts; raise DataError where the primary method gave no result."""
    runs = ((run, details.loaded), (no_load_run, details.no_load))
    quantity = details.compensations[details.primary].measurand if details.primary else ""
    channels = list(torque_instruments(run.instruments.values())) if details.loaded else []
    if _is_loaded(details):
        channels.append(_load_channel(run))
    ranges = [
        Deviation(kind="range", run_id=beyond.run_id, where=beyond.channel, text=beyond.text)
        for beyond in beyond_calibration(details, run, no_load_run)
    ]
    load = [
        Deviation(kind="load", run_id=run.run_id, where=_load_channel(run), text=text)
        for text in (_load_problem(details, run),)
        if text
    ]
    return CertifiedDetails(
        results=_results(details, run),
        method=details.primary,
        quantity=quantity,
        validity=tuple(_validity(details)),
        channels=frozenset(channels),
        deviations=(*ranges, *load),
        rejected=tuple(
            cycle
            for source_run, points in runs
            if source_run is not None
            for point in points
            for cycle in _rejected(source_run.run_id, point)
        ),
    )


def _results(details: TorqueDetails, run: RunData) -> Results | None:
    """Return the results of the primary method; None where the procedure has none."""
    if not details.primary:
        return None
    if details.headline is None:
        raise DataError(f"{run.run_id} has no result to certify: {details.problem}")
    points = details.compensations[details.primary].points
    return Results(
        headline=stated(details.headline, "the result"),
        motion="start"
        if any(isinstance(point, StartPoint) for point in details.loaded)
        else "swing",
        points=tuple(map(_point, points, details.loaded)),
    )


def _validity(details: TorqueDetails) -> Iterator[ValidityCondition]:
    """Yield on what the results are conditional, by the kind of their measurand."""
    if details.kind is None:
        return
    for code in details.kind.validity:
        allowed = details.support_allowance if code is Validity.SUPPORT_FRICTION else None
        text = "" if allowed is None else f"{printed(allowed[0], 1)} {allowed[1]}"
        yield ValidityCondition(code=code.value, allowance=text)


def _load_problem(details: TorqueDetails, run: RunData) -> str:
    """Return in words why the error of the load is not known; '' where it is known."""
    if not _is_loaded(details):
        return ""
    cell, tolerance = load_cell(run), rig_of(run).load_tolerance
    stated = "load_tolerance" in run.rig_keys
    assumed = f"±{100 * tolerance:.3g} %, " + ("as the station says" if stated else "by default")
    if cell is None:
        return f"no instrument for it is in the station's register; its error is taken as {assumed}"
    if not (cell.certificate or cell.calibration):
        return f"the register names no calibration certificate of {cell.name}"
    least = min(point.load_n for point in details.loaded if point.load_n > 0)
    if cell.limit_of_error(least) is None and not stated:
        return f"the register does not say how accurate {cell.name} is; it is taken as {assumed}"
    return ""


def _load_channel(run: RunData) -> str:
    """Return the channel of the load, 'role.load'."""
    torque = next(iter(torque_instruments(run.instruments.values())), "tester.torque")
    return Member(role_of(torque), "load")


def _is_loaded(details: TorqueDetails) -> bool:
    return any(point.load_n > 0 for point in details.loaded)


def _point(compensated: CompensatedPoint, point: PeakPoint) -> PointResult:
    torque = stated(compensated.torque, f"the result of {point.recording}")
    raw_nm = mean_peak(point).value
    peaks = int(point.peak_kept.sum())
    used = peaks if compensated.cycles_used is None else compensated.cycles_used
    return PointResult(
        recording=point.recording,
        set_frequency_hz=compensated.set_frequency_hz,
        frequency_hz=compensated.frequency_hz,
        load_n=point.load_n,
        cycles=point.cycles,
        cycles_rejected=point.cycles - used,
        raw_nm=raw_nm,
        printed_raw=printed(raw_nm, torque.decimals),
        torque=torque,
    )


def _rejected(run_id: str, point: PeakPoint) -> Iterator[RejectedCycle]:
    for rejection in point.peak_rejections:
        yield _cycle(run_id, point.recording, "peak", rejection)
    if isinstance(point, SwingPoint):
        for rejection in point.waveform_rejections:
            yield _cycle(run_id, point.recording, "waveform", rejection)


def _cycle(
    run_id: str, recording: str, what: Literal["peak", "waveform"], rejection: Rejection
) -> RejectedCycle:
    return RejectedCycle(
        run_id=run_id,
        recording=recording,
        cycle=rejection.index + 1,
        what=what,
        rule=rejection.rule,
        value_nm=finite(rejection.value),
        statistic=finite(rejection.statistic),
        critical=finite(rejection.critical),
        printed_statistic=printed(rejection.statistic, _STATISTIC_DECIMALS),
        printed_critical=printed(rejection.critical, _STATISTIC_DECIMALS),
    )
