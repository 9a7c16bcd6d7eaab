"""What the studies share on the command line: seed, tables, and how they are resumed."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rigrunner.cli.batch import shown_count, worker_options, workers_for
from rigrunner.cli.options import json_option
from rigrunner.cli.output import result, result_json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rigrunner_bearings.study.case_runner import CaseRunner
    from rigrunner_bearings.study.tables import Part

_seed = click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    help="Seed of the random rigs.",
)
_keep = click.option(
    "--keep",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Store progress here, to continue an interrupted study.",
)
_markdown = click.option(
    "--markdown", "as_markdown", is_flag=True, help="Print Markdown, as in the documentation."
)


def study_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that every study has."""
    return worker_options(_keep(_seed(_markdown(json_option(command)))))


def show(
    parts: Iterable[Part], document: Mapping[str, Any], *, as_markdown: bool, as_json: bool
) -> None:
    """Print the results of a study."""
    from rigrunner_bearings.study.tables import markdown, text

    if as_json:
        result_json(document)
    else:
        result(markdown(parts) if as_markdown else text(parts))


@contextmanager
def case_runner(
    study: str, jobs: int | None, dask: str | None, keep: Path | None
) -> Iterator[CaseRunner]:
    """Give the runner of a study's cases; its journal is removed once the tables are printed."""
    from rigrunner.cli.stopping import batch_stop_on_signals
    from rigrunner.jobs import discard
    from rigrunner_bearings.study.case_runner import CaseRunner

    journal_path = keep or Path(f"rigrunner-study-{study}.part")
    workers = workers_for(jobs, dask)
    with batch_stop_on_signals() as stop, shown_count("rigs") as progress:
        yield CaseRunner(workers, stop, progress, journal_path)
    discard(journal_path)
