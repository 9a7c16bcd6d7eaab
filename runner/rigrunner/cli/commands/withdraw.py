"""`rigrunner withdraw`: withdraw a certificate without replacing it."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.cli.ordering import letterhead_option
from rigrunner.cli.output import message, result


@click.command(name="withdraw")
@click.argument("certificate", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--reason", required=True, help="The reason, which `verify` shows.")
@click.option("--by", required=True, metavar="NAME", help="Who withdraws it.")
@letterhead_option
def command(*, certificate: Path, reason: str, by: str, letterhead: Path) -> None:
    """Withdraw a certificate without replacing it.

    Its files do not change. The withdrawal is recorded with its number, and a notice is written
    beside it. It is permanent: only `amend` can replace the certificate.
    """
    from rigrunner.clock import WallClock
    from rigrunner.documents.certifying.withdraw import withdraw

    notice = withdraw(certificate, letterhead, by=by, reason=reason, now=WallClock().utc())
    result(str(notice))
    message("the certificate is withdrawn: inform everyone who has it")
