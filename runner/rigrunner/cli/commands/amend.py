"""`rigrunner amend`: replace a certificate by a new document."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.cli.options import lab_option
from rigrunner.cli.ordering import (
    authorisation,
    letterhead_option,
    order_options,
    order_values,
    out_option,
    show_issued,
)


@click.command(name="amend")
@click.argument("certificate", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--reason", required=True, help="The reason, which is on the document.")
@click.option("--by", required=True, metavar="NAME", help="Who amends and authorises it.")
@click.option("--role", default="", help="That person's function in the laboratory.")
@letterhead_option
@order_options
@click.option("--lang", default="", help="The language; by default the original's.")
@click.option(
    "--run",
    type=click.Path(path_type=Path, exists=True),
    help="State the decision in force on this run, a folder or run.h5.",
)
@out_option
@lab_option
def command(
    *,
    certificate: Path,
    reason: str,
    by: str,
    role: str,
    letterhead: Path,
    lang: str,
    run: Path | None,
    out: Path | None,
    station: str | None,
    **options: str | None,
) -> None:
    """Issue a document that replaces a certificate.

    It has its own number and states the original, the changes and the reason. The original does not
    change.
    """
    from rigrunner.cli.progress import shown_progress
    from rigrunner.clock import WallClock
    from rigrunner.documents.certifying.amend import AmendRequest, amend
    from rigrunner.run.lab_plugins import lab_registry

    request = AmendRequest(
        letterhead=letterhead,
        reason=reason,
        authorisation=authorisation(by, role),
        language=lang,
        out=out,
        changes=order_values(options),
        run=run,
    )
    registry = lab_registry(station)
    with shown_progress() as progress:
        issued = amend(
            certificate, request, registry, WallClock().utc(), progress=progress.analysing
        )
    show_issued(issued)
