"""The instrument register: what each instrument is, and what its calibration says."""

from __future__ import annotations

from math import isinf
from typing import TYPE_CHECKING

from rigrunner.api.accuracy import AccuracyInParts
from rigrunner.api.instruments import TorqueInstrument
from rigrunner.api.quantity import readable
from rigrunner.api.transducer import TemperatureError
from rigrunner_reports.numbers import plain, with_sign

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.data import RunData
    from rigrunner.api.instruments import Instrument, OtherInstrument
    from rigrunner.api.transducer import StatedError

Facts = tuple[tuple[str, str], ...]

NO_CALIBRATION = {
    "simulated": "none: the instrument is simulated",
    "recorded": "none at this run: the values were recorded before it",
    "trial": "none: the set-up is a trial",
}


def instruments(run: RunData) -> tuple[Facts, ...]:
    """Return the register's entries, each as name and text of what is known of it."""
    registered = (*run.instruments.values(), *run.other_instruments)
    return tuple(tuple(_facts(run, each)) for each in registered)


def _facts(run: RunData, each: Instrument) -> Iterator[tuple[str, str]]:
    made = " ".join(part for part in (each.maker, each.type) if part)
    yield "Channel", each.channel
    yield "Instrument", made or "not stated"
    if each.id:
        yield "Number", each.id
    yield "Serial number", each.serial
    yield from _calibration(run, each)
    yield "Range", _range(each)
    if isinstance(each, TorqueInstrument):
        yield from _torque_facts(run, each)
    else:
        yield "Accuracy", _stated(each)
    yield from _conditions(each)


def _calibration(run: RunData, each: Instrument) -> Iterator[tuple[str, str]]:
    if each.calibration is not None:
        yield "Calibration", NO_CALIBRATION[each.calibration]
        return
    certificate = ", ".join(part for part in (each.certificate, each.laboratory) if part)
    yield "Certificate", certificate or "not stated"
    yield "Calibrated", each.calibrated.isoformat() if each.calibrated else "not stated"
    yield "Calibration due", _due(run, each)


def _due(run: RunData, each: Instrument) -> str:
    if each.due is None:
        return "not stated"
    overdue = each.due.isoformat() < run.started_utc[:10]
    return f"{each.due.isoformat()}{', OVERDUE at this run' if overdue else ''}"


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


def _torque_facts(run: RunData, each: TorqueInstrument) -> Iterator[tuple[str, str]]:
    zero = run.zeros.get(each.channel)
    yield "Full scale", f"{plain(each.full_scale)} N·m"
    yield "Accuracy", _accuracy(each)
    for name, stated in each.errors or ():
        if stated is not None:
            yield name.replace("_", " ").capitalize(), _error(stated)
    yield "Low-pass filter", _low_pass(each)
    yield "Zero taken off", "not zeroed" if zero is None else f"{with_sign(zero, 4)} N·m"


def _accuracy(each: TorqueInstrument) -> str:
    limits = each.accuracy
    if limits.of_full_scale:
        corrected = ", by which readings are corrected" if each.interpolation else ""
        points = f", from the calibration points{corrected}" if each.accuracy_ is None else ""
        return f"±{plain(100 * limits.of_full_scale)} % of full scale{points}"
    return (
        f"gain ±{plain(100 * limits.gain)} %, offset ±{plain(limits.offset)} N·m, "
        f"drift ±{plain(limits.drift)} N·m, "
        f"non-linearity ±{plain(100 * limits.nonlinearity)} % of full scale"
    )


def _error(each: StatedError) -> str:
    over = f" per {each.per}, within {each.within}" if isinstance(each, TemperatureError) else ""
    return f"±{each.limit}{over}, {each.distribution} ({each.source})"


def _stated(each: OtherInstrument | Instrument) -> str:
    stated = getattr(each, "accuracy", None)
    if isinstance(stated, AccuracyInParts):
        return ", ".join(f"{name} ±{limit.limit}" for name, limit in stated.limits.items())
    if stated:
        return f"±{stated}"
    return "as of the calibration points" if each.points else "not stated"


def _low_pass(each: TorqueInstrument) -> str:
    known = each.low_pass
    return "not stated" if known is None else known.described[0].upper() + known.described[1:]
