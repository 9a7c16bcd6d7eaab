"""On what the results rest: conditions of validity, calibrations, the load and their ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.analysis.torque.channels import role_of
from rigrunner.api.analysis import SwingPoint
from rigrunner.api.certificate import Traceability, ValidityCondition
from rigrunner.api.instruments import torque_instruments
from rigrunner.api.measurand import Validity
from rigrunner.api.member import Member
from rigrunner.certificate.numerals import printed
from rigrunner.signal.blocks import limits

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api.analysis import PeakPoint
    from rigrunner.api.certificate import InstrumentEntry
    from rigrunner.api.data import RunData
    from rigrunner.api.instruments import Instrument
    from rigrunner.api.results import Result


def validity_of(result: Result) -> Iterator[ValidityCondition]:
    """Yield on what the results are conditional, by the kind of their measurand."""
    if result.kind is None:
        return
    for code in result.kind.validity:
        allowed = _allowance(result) if code is Validity.SUPPORT_FRICTION else ""
        yield ValidityCondition(code=code.value, allowance=allowed)


def traceability_of(result: Result, instruments: Sequence[InstrumentEntry]) -> Traceability:
    """Return whether all calibrations that the results rest on are on record, and which they are.

    Those of the torque, of both runs, and of the load where there is any; of measured values that
    nothing was analysed of, all.
    """
    wanted = _entering(result) or {each.channel for each in instruments}
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


def load_problem(result: Result) -> str:
    """Return in words why it is not known how well the load is known; '' where that is known."""
    if not _is_loaded(result):
        return ""
    cell, tolerance = _load_cell(result.run), result.run.rig.load_tolerance
    stated = "load_tolerance" in result.run.rig.model_fields_set
    assumed = f"±{100 * tolerance:.3g} %, " + ("as the station says" if stated else "by default")
    if cell is None:
        return f"no instrument for it is in the station's register; its error is taken as {assumed}"
    if not (cell.certificate or cell.calibration):
        return f"the register names no calibration certificate of {cell.name}"
    least = min(point.load_n for point in result.loaded if point.load_n > 0)
    if cell.limit_of_error(least) is None and not stated:
        return f"the register does not say how accurate {cell.name} is; it is taken as {assumed}"
    return ""


def load_channel(result: Result) -> str:
    """Return the channel of the load, 'role.load'."""
    return Member(role_of(_torque_channel(result)), "load")


def beyond_calibration(result: Result) -> Iterator[tuple[str, str]]:
    """Yield each channel that went beyond its calibrated range, with how far, in words."""
    for run, points in ((result.run, result.loaded), (result.no_load_run, result.no_load)):
        if run is None or not (points or result.primary):
            continue
        for instrument in torque_instruments(run.instruments.values()).values():
            lowest, highest = _extremes(points)
            yield from _beyond(instrument, lowest, highest, "N·m")
        cell = _load_cell(run)
        if cell is not None:
            loads = [point.load_n for point in points if point.load_n > 0]
            if loads:
                yield from _beyond(cell, min(loads), max(loads), "N")
    if result.other_results and not result.loaded:
        yield from _beyond_measured(result.run)


def _beyond_measured(run: RunData) -> Iterator[tuple[str, str]]:
    """Yield the same of every value that was recorded or measured with an instrument."""
    for instrument in run.instruments.values():
        name = instrument.channel
        values = [row.values[name] for row in run.measurements if name in row.values]
        unit = next((row.units[name] for row in run.measurements if name in row.values), "")
        for recording in run.recordings:
            if name in recording.channels and recording.samples:
                values.extend(limits(recording.channels[name]))
                unit = recording.units[name]
        if values:
            yield from _beyond(instrument, min(values), max(values), unit)


def _beyond(
    instrument: Instrument, lowest: float, highest: float, unit: str
) -> Iterator[tuple[str, str]]:
    bounds = instrument.calibrated_range
    if bounds is None or bounds[0] <= lowest <= highest <= bounds[1]:
        return
    worst, bound = (
        (highest, bounds[1]) if highest - bounds[1] >= bounds[0] - lowest else (lowest, bounds[0])
    )
    share = f" ({100 * worst / bound:.0f} %)" if bound else ""
    text = f"{worst:.4g} {unit} was recorded, the calibration holds up to {bound:.4g} {unit}{share}"
    yield instrument.channel, text


def _extremes(points: Sequence[PeakPoint]) -> tuple[float, float]:
    """Return the least and the greatest torque of what was kept, in N·m; 0 is always within."""
    values = [0.0]
    for point in points:
        values.extend((float(point.peak_nm[point.peak_kept].max(initial=0.0)),))
        if isinstance(point, SwingPoint):
            kept = point.torque_nm[point.kept]
            values.extend((float(kept.min(initial=0.0)), float(kept.max(initial=0.0))))
    return min(values), max(values)


def _entering(result: Result) -> set[str]:
    torque = torque_instruments(result.run.instruments.values()) if result.loaded else ()
    return set(torque) | ({load_channel(result)} if _is_loaded(result) else set())


def _is_loaded(result: Result) -> bool:
    return any(point.load_n > 0 for point in result.loaded)


def _torque_channel(result: Result) -> str:
    return next(iter(torque_instruments(result.run.instruments.values())), "tester.torque")


def _load_cell(run: RunData) -> Instrument | None:
    torque = next(iter(torque_instruments(run.instruments.values())), "")
    return run.instruments.get(f"{role_of(torque)}.load")


def _allowance(result: Result) -> str:
    """Return by how much the supports' friction may grow with load."""
    allowed = result.support_allowance
    return "" if allowed is None else f"{printed(allowed[0], 1)} {allowed[1]}"
