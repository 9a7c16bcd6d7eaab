"""The options of an order, which `certify` and `amend` share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

OPTIONS = {
    "--customer": "The customer's name.",
    "--customer-contact": "The customer's address or other contact.",
    "--customer-reference": "The customer's own number of the order.",
    "--item": "What was tested, in words.",
    "--item-id": "By what the item is told from others.",
    "--item-condition": "The state in which the item was received.",
    "--received": "The date of receipt, as 2026-01-31.",
    "--sampling": "Plan and method of sampling, where the laboratory did it.",
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
    help="The folder to write into; left out, that of the run or document.",
)


def order_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of an order to a command."""
    for option, words in reversed(OPTIONS.items()):
        command = click.option(option, help=words, metavar=_metavar(option))(command)
    return command


def order_values(given: Mapping[str, str | None]) -> dict[str, str]:
    """Return the options that were given, by the name of their field."""
    return {name: value for name, value in given.items() if value is not None}


def _metavar(option: str) -> str:
    return "DATE" if option == "--received" else "TEXT"
