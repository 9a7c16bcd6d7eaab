"""The instrument register: each instrument with its calibration."""

from __future__ import annotations

from math import isinf
from typing import TYPE_CHECKING

from rigrunner.api.instruments import TORQUE, ZEROED
from rigrunner.api.quantity import legible, readable
from rigrunner.api.units import si_symbol
from rigrunner_reports.numbers import with_sign

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api import Instrument, RunData
    from rigrunner.api.accuracy import ErrorLimit

Facts = tuple[tuple[str, str], ...]

NO_CALIBRATION = {
    "simulated": "none: the instrument is simulated",
    "recorded": "none at this run: the values were recorded before it",
    "trial": "none: the set-up is a trial",
}

_IN_ONE_LINE = {
    "overall": "",
    "gain": "gain ",
    "offset": "offset ",
    "drift": "drift ",
    "nonlinearity": "non-linearity ",
}


def instruments(run: RunData) -> tuple[Facts, ...]:
    """Return the register's entries, each as name and text."""
    return tuple(tuple(_facts(run, instrument)) for instrument in run.instruments.values())


def _facts(run: RunData, instrument: Instrument) -> Iterator[tuple[str, str]]:
    name = " ".join(filter(None, (instrument.maker, instrument.type)))
    yield "Channel", instrument.channel
    yield "Instrument", name or "not stated"
    if instrument.id:
        yield "Number", instrument.id
    yield "Serial number", instrument.serial
    yield from _calibration(run, instrument)
    yield "Range", _range(instrument)
    if instrument.full_scale_ is not None:
        yield "Full scale", str(readable(instrument.full_scale, instrument.quantity))
    yield from _accuracy(instrument)
    if instrument.quantity == TORQUE or instrument.low_pass is not None:
        text = "" if instrument.low_pass is None else instrument.low_pass.described
        yield "Low-pass filter", text[:1].upper() + text[1:] or "not stated"
    zero = run.zeros.get(instrument.channel)
    if zero is not None:
        symbol = si_symbol(instrument.quantity)
        is_torque = instrument.quantity == TORQUE
        zero_text = f"{with_sign(zero, 4)} {symbol}" if is_torque else legible(zero, symbol)
        yield "Zero taken off", zero_text
    elif instrument.quantity in ZEROED:
        yield "Zero taken off", "not zeroed"
    yield from _conditions(instrument)


def _calibration(run: RunData, instrument: Instrument) -> Iterator[tuple[str, str]]:
    if instrument.calibration is not None:
        yield "Calibration", NO_CALIBRATION[instrument.calibration]
        return
    certificate = ", ".join(filter(None, (instrument.certificate, instrument.laboratory)))
    yield "Certificate", certificate or "not stated"
    yield "Calibrated", instrument.calibrated.isoformat() if instrument.calibrated else "not stated"
    due = instrument.due.isoformat() if instrument.due else "not stated"
    overdue = instrument.due is not None and due < max(run.started_utc, run.ended_utc)[:10]
    yield "Calibration due", f"{due}{', OVERDUE at this run' if overdue else ''}"


def _range(instrument: Instrument) -> str:
    bounds = instrument.calibrated_range
    if bounds is None or not (instrument.range_ or instrument.points):
        return "not stated"
    lowest, highest = bounds
    top = str(readable(highest, instrument.quantity))
    return f"up to {top}" if isinf(lowest) else f"{readable(lowest, instrument.quantity)} to {top}"


def _conditions(instrument: Instrument) -> Iterator[tuple[str, str]]:
    conditions = instrument.conditions
    if conditions is None:
        return
    for name, dimension in (("temperature", "temperature"), ("humidity", "ratio")):
        span = getattr(conditions, name)
        if span is not None:
            lowest, highest = (readable(value, dimension) for value in (span.min, span.max))
            yield f"Calibrated for {name}", f"{lowest} to {highest}"


def _accuracy(instrument: Instrument) -> Iterator[tuple[str, str]]:
    """Yield the usual limits in one line, and each other one with its source."""
    accuracy = instrument.accuracy
    limits = accuracy.limits if accuracy else {}
    first = {name: limit for name, limit in limits.items() if name in _IN_ONE_LINE}
    parts = [f"{_IN_ONE_LINE[name]}±{_words(name, limit)}" for name, limit in first.items()]
    if "overall" in first and accuracy is not instrument.accuracy_:
        corrected = ", by which readings are corrected" if instrument.interpolation else ""
        width = readable(float(f"{instrument.half_width('overall'):.6g}"), instrument.quantity)
        parts[0] = f"±{width}, from the calibration points{corrected}"
    yield "Accuracy", ", ".join(parts) or ("see below" if limits else "not stated")
    for name, limit in limits.items():
        if name not in first:
            sign = "" if name == "resolution" else "±"  # it is a step, of which the error is half
            text = f"{sign}{limit.described}, {limit.distribution}{_source(limit)}"
            yield name.replace("_", " ").capitalize(), text


def _words(name: str, limit: ErrorLimit) -> str:
    """Return a limit with its distribution and source, if these are not the usual ones."""
    number, share, of = limit.limit.partition("%")
    words = {"FS": " of full scale", "reading": "" if name == "gain" else " of reading"}
    shown = f"{number.strip()} %{words[of.strip()]}" if share else limit.limit
    shape = "" if limit.distribution == "rectangular" else f", {limit.distribution}"
    return shown + shape + _source(limit)


def _source(limit: ErrorLimit) -> str:
    return f" ({limit.source})" if limit.source else ""
