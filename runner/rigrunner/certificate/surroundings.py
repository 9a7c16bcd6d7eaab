"""Instruments and conditions of a run, as a certificate shows them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import Condition, InstrumentEntry
from rigrunner.certificate.numerals import printed

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.calibration import TorqueAccuracy
    from rigrunner.api.data import RunData
    from rigrunner.api.instruments import TorqueInstrument

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
        for channel, value in measurement.values.items():
            seen.setdefault(channel, []).append(value)
    for channel, values in seen.items():
        quantity = channel.rpartition(".")[2]
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


def instruments_of(run: RunData) -> Iterator[InstrumentEntry]:
    """Yield the register of the run's station."""
    for channel, each in run.instruments.items():
        yield _entry(channel, each, run.started_utc[:10])


def _entry(channel: str, each: TorqueInstrument, day: str) -> InstrumentEntry:
    due = "" if each.due is None else each.due.isoformat()
    return InstrumentEntry(
        channel=channel,
        maker=each.maker,
        type=each.type,
        serial=each.serial,
        certificate=each.certificate,
        laboratory=each.laboratory,
        calibrated="" if each.calibrated is None else each.calibrated.isoformat(),
        due=due,
        range=f"{each.full_scale:.6g} N·m",
        uncertainty=_accuracy(each.accuracy),
        overdue=bool(due) and due < day,
    )


def _accuracy(limits: TorqueAccuracy) -> dict[str, str]:
    if limits.of_full_scale:
        return {"of full scale": f"±{100 * limits.of_full_scale:.6g} %"}
    return {
        "gain": f"±{100 * limits.gain:.6g} %",
        "offset": f"±{limits.offset:.6g} N·m",
        "drift": f"±{limits.drift:.6g} N·m",
        "nonlinearity": f"±{100 * limits.nonlinearity:.6g} %",
    }
