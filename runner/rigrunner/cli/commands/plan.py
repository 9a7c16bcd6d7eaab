"""`rigrunner plan`: preview a run without accessing a rig."""

from __future__ import annotations

from dataclasses import asdict
from textwrap import shorten
from typing import TYPE_CHECKING

import click

from rigrunner.api.coordinates import coordinates_text
from rigrunner.api.summaries import pairs, table
from rigrunner.cli.durations import clock_text
from rigrunner.cli.options import json_option, procedure_argument, runs_option, station_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.run.locate import find_procedure, find_station

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.plan import PredictedReading, Prediction
    from rigrunner.run.prepare import Planned


@click.command(name="plan")
@procedure_argument
@station_option
@runs_option
@json_option
def command(procedure: str, station: str, runs: Path, *, as_json: bool) -> None:
    """Preview steps, expected values, duration and disk space.

    Nothing is connected. Expected readings are upper estimates from the station's design values. A
    partner run that is not in the folder of runs is an error, shown with its line after the plan.
    """
    from rigrunner.run.calibration import calibration_findings
    from rigrunner.run.planning import planned_run

    planned = planned_run(find_procedure(procedure), find_station(station))
    prediction = planned.prediction()
    if as_json:
        result_json(
            {
                "procedure": planned.procedure.model.id,
                "station": planned.station.model.id,
                "estimated_s": planned.plan.estimated_s,
                "disk_bytes": prediction.disk_bytes,
                "readings": [{**asdict(each), "share": each.share} for each in prediction.readings],
                "steps": [
                    {
                        "do": type(step.action).__name__.lower(),
                        "path": step.path,
                        **{name: value for name, value in asdict(step).items() if name != "within"},
                    }
                    for step in planned.plan.steps
                ],
            }
        )
    else:
        result("\n\n".join(_sections(planned, prediction)))
        for reading in prediction.overloads:
            message(f"warning: {reading.recording} would overload {reading.channel}")
        for finding in calibration_findings(planned):
            message(f"warning: {finding.problem.message}")
    if runs.is_dir():
        from rigrunner.run.partners import require_partners

        require_partners(planned, runs)


def _sections(planned: Planned, prediction: Prediction) -> Iterator[str]:
    steps = planned.plan.steps
    rows = []
    for number, step in enumerate(steps, 1):
        seconds = f"{step.estimated_s:.1f} s" if step.estimated_s else ""
        rows.append([str(number), step.phase, shorten(step.text, 56, placeholder=" …"), seconds])
    header, align = ["step", "phase", "action", "time"], "rllr"
    if any(step.coordinates for step in steps):
        header, align = [*header, "coordinates"], f"{align}l"
        places = [
            coordinates_text(step.coordinates, step.coordinate_units, step.written_in)
            for step in steps
        ]
        rows = [[*row, text] for row, text in zip(rows, places, strict=True)]
    yield table(header, rows, align)
    drives = table(["drive", "range", "allowed"], _drive_rows(planned), "lrr")
    yield f"Limits of the drives\n{drives}"
    if planned.plan.interlocks:
        interlocks = planned.plan.interlocks
        rows = [[each.name, each.member, each.condition, each.does] for each in interlocks]
        yield f"Interlocks\n{table(['name', 'channel', 'trips', 'does'], rows, 'llll')}"
    if prediction.readings:
        readings = [_reading_row(reading) for reading in prediction.readings]
        header = ["recording", "channel", "peak", "full scale", "used"]
        yield f"Expected readings, at most\n{table(header, readings, 'llrrr')}"
    most = "at most " if planned.plan.has_conditions else ""
    yield pairs(
        [
            ("steps", f"{most}{len(steps)}"),
            ("duration", f"{most}{clock_text(planned.plan.estimated_s)}"),
            ("disk", f"{most}{prediction.disk_bytes / 1e6:.1f} MB of samples, before compression"),
        ]
    )


def _reading_row(reading: PredictedReading) -> list[str]:
    return [
        reading.recording,
        reading.channel,
        f"{reading.peak:.3g} {reading.unit}",
        f"{reading.full_scale:g} {reading.unit}",
        f"{reading.share:.0%}",
    ]


def _drive_rows(planned: Planned) -> list[list[str]]:
    """Each drive that the plan sets: how far it goes, and how far it may."""
    from rigrunner.api.member import Member
    from rigrunner.api.units import from_si

    reached: dict[Member, list[float]] = {}
    symbols: dict[Member, set[str]] = {}
    for step in planned.plan.steps:
        if drive := step.action.moves:
            reached.setdefault(drive, []).extend(step.action.moves_to)
            symbols.setdefault(drive, set()).add(step.written_in.get(drive, ""))
    narrower = planned.station.model.safety.drives
    drives = {
        Member(role, d.name): d for role, device in planned.devices.items() for d in device.drives
    }
    allowed = {n: narrower[n].narrowed(d) if n in narrower else d for n, d in drives.items()}

    def span(name: Member, low: float, high: float) -> str:
        unit = "".join(symbols[name] if len(symbols[name]) == 1 else "") or drives[name].unit
        return f"{from_si(low, unit):.6g} to {from_si(high, unit):.6g} {unit}"

    return [
        [
            name,
            span(name, min(reached[name]), max(reached[name])),
            span(name, drive.minimum, drive.maximum),
        ]
        for name, drive in allowed.items()
        if name in reached
    ]
