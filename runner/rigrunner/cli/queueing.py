"""Options of the commands of the queue."""

from __future__ import annotations

import getpass
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from collections.abc import Callable


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # a container may have no name for it
        return "terminal"


by_option = click.option(
    "--by", default=_user, metavar="NAME", help="Who decides; by default the user name."
)


def reason_option(*, required: bool) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return the option of a reason, which goes into the queue."""
    if required:
        return click.option("--reason", required=True, metavar="TEXT", help="Why.")
    return click.option("--reason", default="", metavar="TEXT", help="Why.")
