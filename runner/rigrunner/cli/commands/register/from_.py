"""`rigrunner register from`: make an entry of the register from a calibration run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option, lab_option, run_argument, runs_option
from rigrunner.cli.output import result, result_json

if TYPE_CHECKING:
    from datetime import datetime
    from pathlib import Path


@click.command(name="from")
@run_argument
@click.option("--channel", required=True, help="The entry's channel, such as tester.torque.")
@click.option(
    "--due",
    required=True,
    type=click.DateTime(["%Y-%m-%d"]),
    help="When the instrument is to be calibrated again.",
)
@click.option("--serial", default="", help="Its serial number; by default the run's specimen.")
@click.option("--laboratory", default="", help="Who calibrated it; by default the run's station.")
@click.option(
    "--full-scale",
    default="",
    help="Full scale; where the entry needs one, by default the highest applied value.",
)
@runs_option
@lab_option
@json_option
def command(
    *,
    run: str,
    channel: str,
    due: datetime,
    serial: str,
    laboratory: str,
    full_scale: str,
    runs: Path,
    station: str | None,
    as_json: bool,
) -> None:
    """Create an entry for the register from a calibration run.

    RUN is a sealed run with a result 'deviation' (indicated minus applied) at each applied value;
    the guide on calibrating a transducer has a procedure. It is verified first. The printed entry
    goes under 'instruments:' of a station.
    """
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.run.locate import find_run
    from rigrunner.tools.registering import EntryDetails, entry_from, entry_yaml

    details = EntryDetails(channel, due.date(), serial, laboratory, full_scale)
    entry = entry_from(find_run(run, runs), details, lab_registry(station))
    if as_json:
        result_json(entry)
    else:
        result(entry_yaml(entry))
