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
    return tuple(tuple(_facts(run, each)) for each in run.instruments.values())


def _facts(run: RunData, each: Instrument) -> Iterator[tuple[str, str]]:
    made = " ".join(part for part in (each.maker, each.type) if part)
    yield "Channel", each.channel
    yield "Instrument", made or "not stated"
    if each.id:
        yield "Number", each.id
    yield "Serial number", each.serial
    yield from _calibration(run, each)
    yield "Range", _range(each)
    if each.full_scale_ is not None:
        yield "Full scale", str(readable(each.full_scale, each.quantity))
    yield from _accuracy(each)
    if each.quantity == TORQUE or each.low_pass is not None:
        words = "" if each.low_pass is None else each.low_pass.described
        yield "Low-pass filter", words[:1].upper() + words[1:] or "not stated"
    zero = run.zeros.get(each.channel)
    if zero is not None:
        symbol = si_symbol(each.quantity)
        is_torque = each.quantity == TORQUE
        text = f"{with_sign(zero, 4)} {symbol}" if is_torque else legible(zero, symbol)
        yield "Zero taken off", text
    elif each.quantity in ZEROED:
        yield "Zero taken off", "not zeroed"
    yield from _conditions(each)


def _calibration(run: RunData, each: Instrument) -> Iterator[tuple[str, str]]:
    if each.calibration is not None:
        yield "Calibration", NO_CALIBRATION[each.calibration]
        return
    certificate = ", ".join(part for part in (each.certificate, each.laboratory) if part)
    yield "Certificate", certificate or "not stated"
    yield "Calibrated", each.calibrated.isoformat() if each.calibrated else "not stated"
    due = each.due.isoformat() if each.due else "not stated"
    overdue = each.due is not None and due < max(run.started_utc, run.ended_utc)[:10]
    yield "Calibration due", f"{due}{', OVERDUE at this run' if overdue else ''}"


def _range(each: Instrument) -> str:
    bounds = each.calibrated_range
    if bounds is None or not (each.range_ or each.points):
        return "not stated"
    lowest, highest = bounds
    top = str(readable(highest, each.quantity))
    return f"up to {top}" if isinf(lowest) else f"{readable(lowest, each.quantity)} to {top}"


def _conditions(each: Instrument) -> Iterator[tuple[str, str]]:
    found = each.conditions
    if found is None:
        return
    for name, dimension in (("temperature", "temperature"), ("humidity", "ratio")):
        span = getattr(found, name)
        if span is not None:
            lowest, highest = (readable(value, dimension) for value in (span.min, span.max))
            yield f"Calibrated for {name}", f"{lowest} to {highest}"


def _accuracy(each: Instrument) -> Iterator[tuple[str, str]]:
    """Yield the usual limits in one line, and each other one with its source."""
    known = each.accuracy
    limits = known.limits if known else {}
    first = {name: limit for name, limit in limits.items() if name in _IN_ONE_LINE}
    parts = [f"{_IN_ONE_LINE[name]}±{_words(name, limit)}" for name, limit in first.items()]
    if "overall" in first and known is not each.accuracy_:
        corrected = ", by which readings are corrected" if each.interpolation else ""
        width = readable(float(f"{each.half_width('overall'):.6g}"), each.quantity)
        parts[0] = f"±{width}, from the calibration points{corrected}"
    yield "Accuracy", ", ".join(parts) or ("see below" if limits else "not stated")
    for name, other in limits.items():
        if name not in first:
            shown = f"±{other.described}, {other.distribution}{_source(other)}"
            yield name.replace("_", " ").capitalize(), shown


def _words(name: str, limit: ErrorLimit) -> str:
    """Return a limit with its distribution and source, if these are not the usual ones."""
    number, share, of = limit.limit.partition("%")
    words = {"FS": " of full scale", "reading": "" if name == "gain" else " of reading"}
    shown = f"{number.strip()} %{words[of.strip()]}" if share else limit.limit
    shape = "" if limit.distribution == "rectangular" else f", {limit.distribution}"
    return shown + shape + _source(limit)


def _source(limit: ErrorLimit) -> str:
    return f" ({limit.source})" if limit.source else ""
