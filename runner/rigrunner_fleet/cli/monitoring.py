"""Shared by the commands that study many runs: their options, and their output."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import json_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigrunner.api.studies import StudyInput
    from rigrunner_fleet.monitoring.observing import Observations

GROUPS = ("type", "lot", "rig", "mandrel", "specimen", "operator", "procedure", "revision")
"""Columns of the archive by which runs can be grouped."""

_out_option = click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Write the report there, such as trend.html.",
)
by_option = click.option(
    "--by",
    multiple=True,
    type=click.Choice(GROUPS),
    help="Group the runs by this column; may be repeated.",
)


def output_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of the output."""
    return _out_option(json_option(command))


def read_observations(
    quantity: str, options: Mapping[str, Any], by: Sequence[str], runs: Path, database: str
) -> Observations:
    """Return the values of a quantity in the archive."""
    from rigrunner_fleet.archive import open_archive  # noqa: PLC0415  (SQLAlchemy takes a while)
    from rigrunner_fleet.cli.archiving import filters_in  # noqa: PLC0415  (so does it)
    from rigrunner_fleet.monitoring.observing import observe  # noqa: PLC0415  (so does SciPy)

    with closing(open_archive(runs, database)) as archive:
        return observe(archive, quantity, filters_in(options), by)


def refuse_limit(limit: int | None) -> None:
    """Refuse --limit: a study of the newest runs would change with each new run."""
    if limit is not None:
        raise UsageError(
            "--limit does not go with a study: with each new run it would be one of other runs",
            hint="--since names the first day",
        )


def question_of(quantity: str, options: Mapping[str, Any], **more: str) -> dict[str, str]:
    """Return the question as the report shows it."""
    chosen = {
        name.replace("_", " "): ", ".join(value) if isinstance(value, tuple) else str(value)
        for name, value in options.items()
        if value not in (None, (), "", False)
    }
    return {"quantity": quantity, **chosen, **{name: text for name, text in more.items() if text}}


def finish(study: StudyInput, text: str, out: Path | None, *, as_json: bool) -> None:
    """Print a study, and write its report if a file is named."""
    from rigrunner_fleet.monitoring.report import (  # noqa: PLC0415  (it loads plugins)
        study_document,
        write_study,
    )

    if as_json:
        result_json(study_document(study))
    else:
        result(text)
    if out is not None:
        write_study(study, out)
        message(f"Wrote {out}.")
