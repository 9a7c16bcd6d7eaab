"""`rigrunner queue add`: add specimens from the command line, a file or a scanner."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import (
    named_values,
    procedure_argument,
    runs_option,
    set_option,
    station_option,
)
from rigrunner.cli.queueing import by_option
from rigrunner.run.locate import find_procedure, find_station

if TYPE_CHECKING:
    from rigrunner.api.errors import Problem

LONGEST_FILE = 1_000_000


@click.command(name="add")
@procedure_argument
@click.argument("specimens", nargs=-1)
@station_option
@runs_option
@set_option
@click.option(
    "--file",
    "listed",
    type=click.Path(path_type=Path, allow_dash=True, dir_okay=False),
    help="A list of specimens, one per line, or a CSV whose first line names inputs; - for stdin.",
)
@click.option("--again", default="", help="Why specimens that have a run are tested again.")
@click.option("--propose", is_flag=True, help="Let a person release the entries first.")
@by_option
def command(
    procedure: str,
    specimens: tuple[str, ...],
    station: str,
    assigned: tuple[str, ...],
    *,
    runs: Path,
    listed: Path | None,
    again: str,
    propose: bool,
    by: str,
) -> None:
    """Add specimens to the queue.

    PROCEDURE is a file, or the name of a shipped procedure. Name procedure and station as seen from
    the lab folder, so that the panel finds them too. Inputs that are not given are asked when the
    run starts.
    """
    from rigrunner.api.errors import InvalidFileError
    from rigrunner.cli.output import result
    from rigrunner.clock import WallClock
    from rigrunner.procedure import load_procedure
    from rigrunner.queue import Draft, Queue, accepted_inputs, read_list

    loaded = load_procedure(find_procedure(procedure))
    find_station(station)
    common, expected = named_values(assigned), loaded.inputs
    invalid: list[Problem] = []
    inputs = [accepted_inputs({**common, "specimen": specimen}, expected) for specimen in specimens]
    if listed is not None:
        items, invalid = read_list(_text(listed), expected, str(listed))
        inputs += [{**accepted_inputs(common, expected), **item.inputs} for item in items]
    elif not specimens:
        inputs = [accepted_inputs(common, expected)]
    drafts = [
        Draft(procedure=procedure, station=PurePath(station).as_posix(), inputs=values, again=again)
        for values in inputs
    ]
    try:
        entries = Queue(runs).add(
            drafts,
            by,
            WallClock().utc(),
            procedure_id=loaded.model.id,
            proposed=propose,
            invalid=invalid,
        )
    except InvalidFileError as error:  # some name a field of the screen
        hint = "give the reason with --again"
        raise InvalidFileError(
            replace(problem, field="", hint=hint) if problem.field == "again" else problem
            for problem in error.problems
        ) from error
    for entry in entries:
        result(f"{entry.id}  {entry.specimen}  {entry.state}")


def _text(path: Path) -> str:
    from rigrunner.api.errors import DataError
    from rigrunner.queue import list_text

    try:
        is_stdin = str(path) == "-"
        text = sys.stdin.read(LONGEST_FILE + 1) if is_stdin else ""
        if (len(text) if is_stdin else path.stat().st_size) > LONGEST_FILE:
            raise DataError(f"{path} is longer than {LONGEST_FILE} bytes", hint="add it in parts")
        return text if is_stdin else list_text(path.read_bytes(), str(path))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DataError(f"cannot read {path}: {reason}") from error
