"""Instruments and conditions of a run, for a certificate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import Condition, InstrumentEntry
from rigrunner.api.member import Member, channel_of
from rigrunner.api.units import si_symbol
from rigrunner.signal.rounding import LEAST_PLACES, printed

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.accuracy import ErrorLimit
    from rigrunner.api.data import RunData
    from rigrunner.api.instruments import Instrument

_IN_SI = ("overall", "gain", "offset", "drift", "nonlinearity")
_KELVIN = 273.15
_SHOWN: Mapping[str, tuple[str, float, float, int]] = {
    "temperature": ("°C", 1.0, -_KELVIN, 1),
    "humidity": ("%", 100.0, 0.0, 0),
    "load": ("N", 1.0, 0.0, 0),
}
"""Quantities that are conditions: printed unit, factor and summand from SI, decimals. Other
quantities read during recordings are part of the measurement."""


def conditions_of(run: RunData) -> Iterator[Condition]:
    """Yield the range of each condition over the recordings and measurements of a run."""
    seen: dict[str, list[float]] = {}
    for recording in run.recordings:
        for channel, value in recording.conditions.items():
            seen.setdefault(channel, []).append(value)
    for measurement in run.measurements:
        for name, value in measurement.values.items():
            statistic = name.removeprefix(channel_of(name))
            # Peak-to-peak and root mean square are no values of the condition itself.
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
    """Yield the registers of the stations of these runs, each entry once."""
    seen: list[InstrumentEntry] = []
    for run in runs:
        if run is None:
            continue
        for instrument in run.instruments.values():
            entry = _entry(instrument, max(run.started_utc, run.ended_utc)[:10])
            if entry not in seen:
                seen.append(entry)
                yield entry


def _entry(instrument: Instrument, day: str) -> InstrumentEntry:
    """Return an entry of the register, for a run that ended on that day."""
    due = "" if instrument.due is None else instrument.due.isoformat()
    error_limits = instrument.accuracy_.limits if instrument.accuracy_ is not None else {}
    uncertainty = dict(_limit(instrument, name, limit) for name, limit in error_limits.items())
    if instrument.points:
        uncertainty["points"] = "; ".join(
            f"{p.applied}: {p.indicated}, U = {p.U} (k = {p.k:.6g})" for p in instrument.points
        )
    conditions = {}
    for name in ("temperature", "humidity"):
        limits = getattr(instrument.conditions, name, None)
        if limits is not None:
            condition = _condition(name, name, limits.min, limits.max)
            printed_range = f"{condition.printed_minimum} … {condition.printed_maximum}"
            conditions[name] = f"{printed_range} {condition.unit}"
    return InstrumentEntry(
        channel=instrument.channel,
        id=instrument.id,
        maker=instrument.maker,
        type=instrument.type,
        serial=instrument.serial,
        certificate=instrument.certificate,
        laboratory=instrument.laboratory,
        calibrated="" if instrument.calibrated is None else instrument.calibrated.isoformat(),
        due=due,
        range=_range(instrument),
        uncertainty=uncertainty,
        conditions=conditions,
        overdue=bool(due) and due < day,  # the day itself is the last one of use
        calibration=instrument.calibration or "calibrated",
    )


def _range(instrument: Instrument) -> str:
    if instrument.range_ is not None:
        lowest, highest = instrument.range_.min, instrument.range_.max
        return f"≤ {highest}" if lowest is None else f"{lowest} … {highest}"
    if instrument.full_scale_ is not None:
        return f"±{instrument.full_scale:.6g} {si_symbol(instrument.quantity)}"
    return ""


def _limit(instrument: Instrument, name: str, limit: ErrorLimit) -> tuple[str, str]:
    """Return one limit under its printed name, as written.

    In a unit of LEAST_PLACES the first limits are in that unit and %, as in version 0.1.0, whose
    certificates are compared with this output.
    """
    si = si_symbol(instrument.quantity)
    if si in LEAST_PLACES and name in _IN_SI:
        share, absolute = limit.in_parts(1.0)
        if name == "gain":
            return name, f"±{100 * share:.6g} %"
        if limit.limit.endswith("FS"):
            key = "of_full_scale" if name == "overall" else name
            return key, f"±{100 * absolute:.6g} %"
        if not share and name != "overall":
            return name, f"±{absolute:.6g} {si}"
    if name == "overall":
        return "accuracy", limit.limit
    sign = "" if name == "resolution" else "±"  # it is a step, of which the error is half
    return f"limit_{name}", f"{sign}{limit.described}"
