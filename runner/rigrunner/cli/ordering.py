"""The options of an order, which `certify` and `amend` share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.output import message, result

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.api.certificate import Authorisation
    from rigrunner.documents.certifying.office import Issued

OPTIONS = {
    "--customer": "The customer's name.",
    "--customer-contact": "The customer's address or other contact.",
    "--customer-reference": "The customer's order number.",
    "--item": "What was tested, in words.",
    "--item-id": "The identification of the item.",
    "--item-condition": "The condition of the item when received.",
    "--received": "The date of receipt, such as 2026-01-31.",
    "--sampling": "Plan and method of sampling, if the laboratory did it.",
    "--operator": "Who measured.",
}

letterhead_option = click.option(
    "--letterhead",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("letterhead"),
    show_default=True,
    help="The laboratory's folder, which also holds its sequence of numbers.",
)
out_option = click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    help="The folder to write into; by default that of the run or document.",
)


def order_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of an order to a command."""
    for option, words in reversed(OPTIONS.items()):
        metavar = "DATE" if option == "--received" else "TEXT"
        command = click.option(option, help=words, metavar=metavar)(command)
    return command


def order_values(options: Mapping[str, str | None]) -> dict[str, str]:
    """Return the given options by the name of their field."""
    return {name: value for name, value in options.items() if value is not None}


def authorisation(by: str, role: str) -> Authorisation:
    """Return who authorises; raise UsageError for an empty name."""
    from rigrunner.api.certificate import Authorisation  # noqa: PLC0415  (pydantic; only here)

    if not by.strip():
        raise UsageError("a certificate needs the name of the person who authorises it")
    return Authorisation(by=by.strip(), role=role.strip())


def show_issued(issued: Issued) -> None:
    """Print the paths of the issued files, and the notes."""
    for note in issued.notes:
        message(note)
    for path in issued.files:
        result(str(path))
    message(f"{issued.certificate.number} is issued: {len(issued.files)} files")
