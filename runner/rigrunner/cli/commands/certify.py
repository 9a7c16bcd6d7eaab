"""`rigrunner certify`: issue a certificate for a stored run."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.cli.options import lab_option, run_argument, runs_option
from rigrunner.cli.ordering import (
    authorisation,
    letterhead_option,
    order_options,
    order_values,
    out_option,
    show_issued,
)


@click.command(name="certify")
@run_argument
@click.option("--authorised-by", required=True, metavar="NAME", help="Who authorises it.")
@click.option("--role", default="", help="That person's function in the laboratory.")
@letterhead_option
@click.option(
    "--order",
    "order_file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="A YAML file with the data of the order; options override it.",
)
@order_options
@click.option("--lang", default="", help="The language; by default the letterhead's.")
@click.option(
    "--not-for-certification",
    is_flag=True,
    help="Make a specimen certificate, marked on every page.",
)
@click.option(
    "--further-copy",
    default="",
    metavar="REASON",
    help="Issue a further specimen certificate for a run that has one, for this reason.",
)
@out_option
@runs_option
@lab_option
def command(
    *,
    run: str,
    authorised_by: str,
    role: str,
    letterhead: Path,
    order_file: Path | None,
    lang: str,
    not_for_certification: bool,
    further_copy: str,
    out: Path | None,
    runs: Path,
    station: str | None,
    **options: str | None,
) -> None:
    """Issue a certificate for a stored run.

    It is written as JSON, HTML and PDF, under the next number of the laboratory's sequence. The
    paths of the files are printed.
    """
    from rigrunner.certificate.order import Order, read_order
    from rigrunner.cli.progress import shown_progress
    from rigrunner.clock import WallClock
    from rigrunner.documents.certifying.certify import Request, certify
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.run.locate import find_run

    request = Request(
        letterhead=letterhead,
        order=read_order(order_file) if order_file else Order(),
        authorisation=authorisation(authorised_by, role),
        not_for_certification=not_for_certification,
        language=lang,
        further_copy=further_copy,
        out=out,
        order_fields=order_values(options),
    )
    registry = lab_registry(station)
    with shown_progress() as progress:
        issued = certify(
            find_run(run, runs),
            request,
            registry,
            WallClock().utc(),
            progress=progress.analysing,
        )
    show_issued(issued)
