"""Instruments and conditions of a run, as a certificate shows them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.accuracy import AccuracyInParts
from rigrunner.api.certificate import Condition, InstrumentEntry
from rigrunner.api.instruments import OtherInstrument, TorqueInstrument
from rigrunner.api.member import Member, channel_of
from rigrunner.certificate.numerals import printed

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.data import RunData
from rigrunner.api.instruments import Instrument

_KELVIN = 273.15
_SHOWN: Mapping[str, tuple[str, float, float, int]] = {
    "temperature": ("°C", 1.0, -_KELVIN, 1),
    "humidity": ("%", 100.0, 0.0, 0),
    "load": ("N", 1.0, 0.0, 0),
}
"""The quantities that are conditions: the unit in which they are printed, factor and summand from
SI, decimals. What else a station can read while recording is part of the measurement."""


def conditions_of(run: RunData) -> Iterator[Condition]:
    """Yield the range of each condition over the recordings and measurements of a run."""
    seen: dict[str, list[float]] = {}
    for recording in run.recordings:
        for channel, value in recording.conditions.items():
            seen.setdefault(channel, []).append(value)
    for measurement in run.measurements:
        for name, value in measurement.values.items():
            statistic = name.removeprefix(channel_of(name))
            if statistic in {"", ".mean", ".minimum", ".maximum"}:
                seen.setdefault(channel_of(name), []).append(value)
    for channel, values in seen.items():
        quantity = Member.parse(channel).name
        if quantity in _SHOWN:
            yield _condition(channel, quantity, min(values), max(values))


def _condition(channel: str, quantity: str, lowest: float, highest: float) -> Condition:
    unit, factor, summand, decimals = _SHOWN[quantity]
    low, high = factor * lowest + summand, factor * highest + summand
    return Condition(
        channel=channel,
        quantity=quantity,
        minimum=low,
        maximum=high,
        printed_minimum=printed(low, decimals),
        printed_maximum=printed(high, decimals),
        decimals=decimals,
        unit=unit,
    )


def instruments_of(*runs: RunData | None) -> Iterator[InstrumentEntry]:
    """Yield the registers of the stations of these runs, the same entry once."""
    seen: list[InstrumentEntry] = []
    for run in runs:
        if run is None:
            continue
        for each in (*run.instruments.values(), *run.other_instruments):
            entry = _entry(each, run.started_utc[:10])
            if entry not in seen:
                seen.append(entry)
                yield entry


def _entry(each: Instrument, day: str) -> InstrumentEntry:
    due = "" if each.due is None else each.due.isoformat()
    return InstrumentEntry(
        channel=each.channel,
        id=each.id,
        maker=each.maker,
        type=each.type,
        serial=each.serial,
        certificate=each.certificate,
        laboratory=each.laboratory,
        calibrated="" if each.calibrated is None else each.calibrated.isoformat(),
        due=due,
        range=_range(each),
        uncertainty={**_accuracy(each), **_points(each)},
        conditions=_conditions(each),
        overdue=bool(due) and due < day,
        calibration=each.calibration or "calibrated",
    )


def _range(each: Instrument) -> str:
    if each.range_ is not None:
        lowest, highest = each.range_.min, each.range_.max
        return f"≤ {highest}" if lowest is None else f"{lowest} … {highest}"
    if isinstance(each, TorqueInstrument):
        return f"±{each.full_scale:.6g} N·m"
    return ""


def _accuracy(each: Instrument) -> dict[str, str]:
    if isinstance(each, OtherInstrument):
        stated = each.accuracy
        if isinstance(stated, AccuracyInParts):
            return {f"limit_{name}": f"±{limit.limit}" for name, limit in stated.limits.items()}
        return {"accuracy": stated} if stated else {}
    limits = each.accuracy_ if isinstance(each, TorqueInstrument) else None
    if limits is None:
        return {}
    if limits.of_full_scale:
        return {"of_full_scale": f"±{100 * limits.of_full_scale:.6g} %"}
    return {
        "gain": f"±{100 * limits.gain:.6g} %",
        "offset": f"±{limits.offset:.6g} N·m",
        "drift": f"±{limits.drift:.6g} N·m",
        "nonlinearity": f"±{100 * limits.nonlinearity:.6g} %",
    }


def _points(each: Instrument) -> dict[str, str]:
    lines = [f"{p.applied}: {p.indicated}, U = {p.U} (k = {p.k:.6g})" for p in each.points]
    return {"points": "; ".join(lines)} if lines else {}


def _conditions(each: Instrument) -> dict[str, str]:
    if each.conditions is None:
        return {}
    ranges = {"temperature": each.conditions.temperature, "humidity": each.conditions.humidity}
    return {
        name: _in_shown_unit(name, found.min, found.max)
        for name, found in ranges.items()
        if found is not None
    }


def _in_shown_unit(quantity: str, lowest: float, highest: float) -> str:
    shown = _condition(quantity, quantity, lowest, highest)
    return f"{shown.printed_minimum} … {shown.printed_maximum} {shown.unit}"
