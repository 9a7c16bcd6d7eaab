"""`rigrunner study`: what the program's own checks are worth, measured on simulated rigs."""

from __future__ import annotations

from contextlib import contextmanager
from sys import stderr
from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.stopping import stop_on_signals
from rigrunner.cli.table import table
from rigrunner.workflow.study import run_study
from rigrunner.workflow.study_table import (
    ALARM_HEADER,
    BREAK_HEADER,
    alarm_rows,
    break_rows,
    error_text,
    markdown,
    study_document,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.workflow.study import Study

    Progress = Callable[[int, int], None]

LINES = 20
"""Of progress, where there is no terminal to draw a bar on."""


@click.command(name="study")
@click.argument("what", type=click.Choice(["diagnostics"]))
@click.option(
    "--rigs",
    type=click.IntRange(min=1),
    default=300,
    show_default=True,
    help="Healthy rigs of each simulator.",
)
@click.option(
    "--broken", type=click.IntRange(min=1), help="Rigs with each break; left out, as many."
)
@click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="Processes to use."
)
@click.option(
    "--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Names the rigs."
)
@click.option(
    "--markdown", "as_markdown", is_flag=True, help="Print Markdown, as on the page of the checks."
)
@json_option
def command(
    what: str,  # noqa: ARG001  (there is one study so far, and its name is checked)
    rigs: int,
    broken: int | None,
    jobs: int,
    seed: int,
    *,
    as_markdown: bool,
    as_json: bool,
) -> None:
    """Measure false alarms and misses of the checks on random simulated rigs.

    The same seed gives the same rigs and the same table.
    """
    with stop_on_signals() as stop, _shown() as progress:
        study = run_study(
            healthy_rigs=rigs,
            broken_rigs=broken or rigs,
            seed=seed,
            jobs=jobs,
            stop=stop,
            progress=progress,
        )
    if as_json:
        result_json(study_document(study))
    else:
        result(markdown(study) if as_markdown else _tables(study))


def _tables(study: Study) -> str:
    alarms = table(list(ALARM_HEADER), alarm_rows(study), "lrr")
    breaks = table(list(BREAK_HEADER), break_rows(study), "lllrlr")
    errors = "\n".join(f"{name}: {error_text(each)}" for name, each in study.error.items())
    unseen = "\n".join(
        f"{row.fault.name}: {row.fault.unseen}" for row in study.breaks if row.fault.unseen
    )
    return "\n\n".join(
        [
            f"False alarms on {study.healthy} healthy rigs\n{alarms}",
            f"Error on healthy rigs, rms and largest, in N·m\n{errors}",
            f"Broken rigs\n{breaks}",
            f"Why no check sees a break\n{unseen}",
        ]
    )


@contextmanager
def _shown() -> Iterator[Progress]:
    """Give a bar on a terminal, and a line now and then elsewhere."""
    if not stderr.isatty():
        yield _line
        return
    with click.progressbar(length=1, label="rigs", file=stderr) as bar:

        def move(done: int, of: int) -> None:
            bar.length = of
            bar.update(done - bar.pos)

        yield move


def _line(done: int, of: int) -> None:
    if done * LINES // of > (done - 1) * LINES // of:
        message(f"{done} of {of} rigs")
