"""What identifies a run: procedure, station, specimen, instruments, settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner_reports.numbers import plain, with_sign

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.data import RunData
    from rigrunner.api.instruments import LowPass, TorqueInstrument
    from rigrunner.api.results import Result

COMPLETED = "completed"
STEP = " \N{SINGLE RIGHT-POINTING ANGLE QUOTATION MARK} "
"""Between the parts of a setting's path."""

Facts = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class InstrumentRow:
    """One line of the instrument register."""

    channel: str
    instrument: str
    serial: str
    certificate: str
    due: str
    full_scale: str
    accuracy: str
    low_pass: str
    zero: str


def facts(result: Result) -> Facts:
    """Return what stands at the head of the report."""
    run, no_load = result.run, result.no_load_run
    pairs = [
        ("Run", run.run_id),
        ("Procedure", f"{run.procedure_id}, revision {run.procedure_revision}"),
        ("Station", f"{run.station_id}, mandrel {run.rig.mandrel}"),
        ("Performed", _period(run.started_utc, run.ended_utc)),
        *((name.capitalize(), value) for name, value in run.inputs.items()),
        ("Outcome", run.outcome),
    ]
    if no_load is not None:
        pairs.append(("No-load run", no_load.run_id))
    return tuple(pairs)


def warnings(result: Result) -> tuple[str, ...]:
    """Return what must stand above the number: a run that did not end as it should."""
    runs = [("This run", result.run), ("The no-load run", result.no_load_run)]
    return tuple(
        f"{name} ended as '{run.outcome}', not as completed: it is no full test."
        for name, run in runs
        if run is not None and run.outcome != COMPLETED
    )


def moment(utc: str) -> str:
    """Return '2026-03-02 09:15:00' of an ISO time."""
    return utc[:19].replace("T", " ")


def _period(start_utc: str, end_utc: str) -> str:
    start, end = moment(start_utc), moment(end_utc)
    day = len("2026-01-31 ")
    return f"{start} to {end[day:] if end[:day] == start[:day] else end} UTC"


def instruments(run: RunData) -> tuple[InstrumentRow, ...]:
    """Return the register's entries, with the zero reading of each."""
    return tuple(_instrument(run, name, each) for name, each in run.instruments.items())


def settings(result: Result) -> Facts:
    """Return the settings of the analysis, one a line."""
    return tuple(_flat(result.settings, ()))


def _instrument(run: RunData, name: str, each: TorqueInstrument) -> InstrumentRow:
    made = " ".join(part for part in (each.maker, each.type) if part)
    certificate = ", ".join(part for part in (each.certificate, each.laboratory) if part)
    zero = run.zeros.get(name)
    return InstrumentRow(
        channel=name,
        instrument=made or "not stated",
        serial=each.serial,
        certificate=certificate or "not stated",
        due=_due(run, each),
        full_scale=f"{plain(each.full_scale)} N·m",
        accuracy=_accuracy(each),
        low_pass=_low_pass(each.low_pass),
        zero="not zeroed" if zero is None else f"{with_sign(zero, 4)} N·m",
    )


def _accuracy(each: TorqueInstrument) -> str:
    limits = each.accuracy
    return (
        f"gain ±{plain(100 * limits.gain)} %, offset ±{plain(limits.offset)} N·m, "
        f"drift ±{plain(limits.drift)} N·m, "
        f"non-linearity ±{plain(100 * limits.nonlinearity)} % of full scale"
    )


def _due(run: RunData, each: TorqueInstrument) -> str:
    if each.due is None:
        return "not stated"
    overdue = each.due.isoformat() < run.started_utc[:10]
    return f"{each.due.isoformat()}{', OVERDUE at this run' if overdue else ''}"


def _low_pass(each: LowPass | None) -> str:
    if each is None:
        return "not stated"
    return f"{each.type.capitalize()}, order {each.order}, {plain(each.corner)} Hz"


def _flat(value: object, path: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield (path, text); a plugin {name, settings} adds its name to the path."""
    if isinstance(value, Mapping) and set(value) == {"name", "settings"}:
        inner = tuple(_flat(value["settings"], (*path, str(value["name"]))))
        yield from inner or ((STEP.join(path), str(value["name"])),)
    elif isinstance(value, Mapping):
        for key, each in value.items():
            yield from _flat(each, (*path, str(key)))
    elif isinstance(value, list | tuple) and any(isinstance(each, Mapping) for each in value):
        for each in value:
            yield from _flat(each, path)
    else:
        yield STEP.join(path), _text(value)


def _text(value: object) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_text(each) for each in value) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else f"{value:.12g}" if isinstance(value, float) else str(value)
