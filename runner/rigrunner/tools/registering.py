"""An entry of the register of instruments, made from the laboratory's own calibration.

The run has a result `deviation`, indicated less applied, at each applied value. Where it has also
`reproducibility` (the range over mounting positions) at these, `repeatability` and `hysteresis`,
they enter too. Of a quantity that is zeroed, such as a force, what is indicated without anything
applied is taken off, as a zero step does.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from math import copysign, inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError, first_problem
from rigrunner.api.instruments import DEFAULT_QUANTITY, ZEROED, Instrument
from rigrunner.api.units import unit
from rigrunner.documents.verifying.run import check_run
from rigrunner.documents.verifying.verification import Verification
from rigrunner.procedure import parse_procedure
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import sealed_file_of
from rigrunner.signal.coverage import excess_kurtosis, factor
from rigrunner.signal.rounding import places
from rigrunner.signal.uncertainty import combine
from rigrunner.yamlfile.composer import read_plain

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from datetime import date
    from pathlib import Path

    from rigrunner.api.findings import MeasurementResult
    from rigrunner.api.results import Result
    from rigrunner.registry import Registry
    from rigrunner.runfile import RunHeader

DEVIATION, REPRODUCIBILITY = "deviation", "reproducibility"
WIDTHS = ("repeatability", "hysteresis")
"""Results that are the width of an error; half of the greatest is its limit."""
CUBIC_MIN_POINTS = 4
"""Points in a direction for the interpolation equation; fewer are joined by lines."""


@dataclass(frozen=True)
class EntryDetails:
    """What the run does not know of the entry."""

    channel: str
    due: date
    serial: str = ""
    laboratory: str = ""
    full_scale: str = ""


def entry_yaml(entry: Mapping[str, Any]) -> str:
    """Return an entry in YAML, to be put under `instruments:`."""
    lines = []
    for key, value in entry.items():
        if key == "points":
            lines += ["points:", *(f"  - {_flow_style(point)}" for point in value)]
        else:
            lines.append(f"{key}: {_flow_style(value)}")
    return "\n".join(("  - " if not i else "    ") + line for i, line in enumerate(lines))


def entry_from(path: Path, details: EntryDetails, registry: Registry) -> dict[str, Any]:
    """Return the entry that a calibration gives; raise DataError where it gives none."""
    if sealed_file_of(path) is None:
        raise DataError(f"{path} is not sealed", hint="finish it with 'rigrunner recover'")
    verification = Verification()
    checked = check_run(verification, path, registry)
    if checked is None or verification.differences:
        raise DataError(f"{path} does not verify: {verification.differences[0]}")
    result = checked.result or analyse_stored(checked.stored, registry)
    run = result.run
    if run.outcome != "completed":
        raise DataError(f"{run.run_id} was not completed: {run.outcome}")
    serial = details.serial or run.inputs.get("specimen", "")
    _check_readings(checked.stored.header, run.instruments, serial)
    deviations = _deviations(result)
    applied_unit = _applied(deviations[0])[1]
    kind = unit(applied_unit).dimension
    points = list(_points(result, deviations))
    entry: dict[str, Any] = {"channel": details.channel}
    if kind != DEFAULT_QUANTITY:
        entry["measures"] = kind
    entry |= {
        "serial": serial,
        "certificate": run.run_id,
        "laboratory": details.laboratory or f"this laboratory, station {run.station_id}",
        "calibrated": run.started_utc[:10],
        "due": details.due.isoformat(),
    }
    standards = [each for each in run.instruments.values() if each.serial != serial]
    if not standards or any(
        each.calibration is not None or (each.due and str(each.due) < run.ended_utc[:10])
        for each in standards
    ):
        entry["calibration"] = "trial"  # its standards are not calibrated
    if kind == DEFAULT_QUANTITY or details.full_scale:  # which requires it
        highest = max(abs(_applied(deviation)[0]) for deviation in deviations)
        entry["full_scale"] = details.full_scale or f"{highest:.9g} {applied_unit}"
    cubic = kind in ZEROED and len(points) >= CUBIC_MIN_POINTS
    entry["interpolation"] = "cubic" if cubic else "linear"
    errors = dict(_errors(result))
    if errors:
        entry["accuracy"] = errors
    entry["points"] = points
    try:
        Instrument.model_validate(entry)
    except ValidationError as error:
        raise DataError(f"{run.run_id} gives no entry: {first_problem(error)}") from error
    return entry


def _check_readings(header: RunHeader, instruments: Mapping[str, Instrument], serial: str) -> None:
    """Raise DataError if a deviation is not that of what the calibrated instrument itself shows.

    Of readings that earlier points correct it is what the correction left, and the new points would
    take its place. Of the standard less the instrument it has the wrong sign.
    """
    procedure = parse_procedure(header.procedure_text, header.procedure_id, stored=True).model
    deviation_settings = [
        analysis.settings
        for _, analysis in procedure.analyses_at
        if isinstance(result := analysis.settings.get("result"), dict)
        and result.get("name") == DEVIATION
    ]
    read_channels = {settings.get("of") for settings in deviation_settings}
    own_channels = {each.channel for each in instruments.values() if each.serial == serial}
    for settings in deviation_settings:
        of, minus = settings.get("of"), settings.get("minus")
        if minus in own_channels and of not in own_channels:
            raise DataError(
                f"{DEVIATION} is {of} less {minus}, which is the instrument {serial}:"
                " expected what is indicated less what is applied",
                hint=f"write 'of: {minus}' and 'minus: {of}', and analyse again",
            )
    for instrument in instruments.values():
        if instrument.interpolation and instrument.channel in read_channels | own_channels:
            raise DataError(
                f"{instrument.channel} was read with the correction of its earlier calibration,"
                f" {instrument.certificate or 'the points of the station'}",
                hint="remove its 'interpolation' from the station, and calibrate again",
            )


def _deviations(result: Result) -> list[MeasurementResult]:
    deviations = [each for each in result.results if each.name == DEVIATION]
    numbers = all(
        len(deviation.coordinates) == 1
        and isinstance(next(iter(deviation.coordinates.values())).value, float)
        for deviation in deviations
    )
    if not deviations or not numbers:
        raise DataError(
            f"{result.run.run_id} has no result '{DEVIATION}' at each applied value",
            hint="the guide on calibrating a transducer has a procedure that makes such runs",
        )
    unknown = [deviation for deviation in deviations if not isfinite(deviation.estimate.u)]
    if unknown:
        raise DataError(f"{DEVIATION} at {unknown[0].place}: its uncertainty is not known")
    return deviations


def _applied(deviation: MeasurementResult) -> tuple[float, str]:
    (place,) = deviation.coordinates.values()
    assert isinstance(place.value, float)  # noqa: S101  (checked by `_deviations`)
    return place.value, place.unit


def _points(result: Result, deviations: Sequence[MeasurementResult]) -> Iterator[dict[str, Any]]:
    """Yield the table's lines, each with U by the deviation, the zero and the reproducibility.

    A quantity that is zeroed is stated less its zero. Of others, such as a temperature, what is
    indicated at 0 is a point as any other.
    """
    is_zeroed = unit(_applied(deviations[0])[1]).dimension in ZEROED
    zeros = (each for each in deviations if is_zeroed and _applied(each)[0] == 0)
    zero = next(zeros, None)
    for deviation in deviations:
        applied, symbol = _applied(deviation)
        if deviation is zero:
            continue
        lines = list(deviation.components)
        difference = deviation.estimate.value
        if zero is not None:
            difference -= zero.estimate.value
            lines = list(_without_zero(lines, zero.components))
        width = _reproducibility(result, deviation)
        if width:
            # the effect of a mounting position is a sine of its angle
            half = width / 2
            lines.append(Component(REPRODUCIBILITY, half / sqrt(2), inf, "arcsine", common=True))
        u, dof = combine(lines)
        kurtosis = excess_kurtosis(((line.u, line.distribution) for line in lines), u)
        k = factor(Estimate(difference, u, dof, deviation.of.unit, kurtosis))
        scale = unit(deviation.of.unit).factor / unit(symbol).factor
        difference_unit = unit(deviation.of.unit).symbol
        indicated = applied + difference * scale
        if u > 0:
            indicated = round(indicated, places(k * u * scale, 4))
        yield {
            "applied": f"{applied:.12g} {symbol}",
            "indicated": f"{indicated:.12g} {symbol}",
            "U": f"{k * u:.3g} {difference_unit}",
            "k": float(f"{k:.4g}"),
        }


def _without_zero(lines: Sequence[Component], zero: Sequence[Component]) -> Iterator[Component]:
    """Yield the lines of a difference: an error that both have, such as an offset, counts once."""
    shared = {line.name: line for line in zero if line.common and line.shared}
    for line in lines:
        at_zero = shared.get(line.name) if line.common and line.shared else None
        u = line.u if at_zero is None else abs(_signed(line) - _signed(at_zero))
        yield replace(line, u=u)
    yield from (line for line in zero if line.name not in shared)


def _signed(line: Component) -> float:
    return copysign(line.u, line.sensitivity)


def _reproducibility(result: Result, deviation: MeasurementResult) -> float:
    """Return the reproducibility at an applied value, in the unit of the deviation.

    0 for a run that has none; raises DataError if it has some, but not at this value, or of another
    kind of quantity: U would be too small.
    """
    reproducibilities = [each for each in result.results if each.name == REPRODUCIBILITY]
    gaps = [each for each in result.missing if each.name == REPRODUCIBILITY]
    if not reproducibilities and not gaps:
        return 0.0
    coordinates = {name: value.usual for name, value in deviation.coordinates.items()}
    for reproducibility in reproducibilities:
        place = {name: value.usual for name, value in reproducibility.coordinates.items()}
        if place != coordinates:
            continue
        source, target = unit(reproducibility.of.unit), unit(deviation.of.unit)
        if source.dimension != target.dimension:
            message = f"{REPRODUCIBILITY} is in {source.symbol}, {DEVIATION} in {target.symbol}"
            raise DataError(message, hint=f"state both in {target.symbol}")
        return abs(reproducibility.estimate.value) * source.factor / target.factor
    raise DataError(
        f"there is no {REPRODUCIBILITY} at {deviation.place}",
        hint=f"state it 'per: {next(iter(deviation.coordinates))}', or leave it out",
    )


def _errors(result: Result) -> Iterator[tuple[str, dict[str, str]]]:
    for name in WIDTHS:
        widths = [each for each in result.results if each.name == name]
        if widths:
            half = max(abs(width.estimate.value) for width in widths) / 2
            limit = f"{half:.3g} {widths[0].of.unit}"
            yield name, {"limit": limit, "source": result.run.run_id[:80]}


def _flow_style(value: object) -> str:
    """Return a value in YAML's flow style; a text in quotes where it would be read otherwise."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow_style(item)}" for key, item in value.items()) + "}"
    if not isinstance(value, str):
        return str(value)
    is_word = value.replace(" ", "").replace("·", "").isalpha()
    return (
        value if is_word and read_plain(value) == value else json.dumps(value, ensure_ascii=False)
    )
