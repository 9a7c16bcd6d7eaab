"""`rigrunner schema`: the languages of procedures and stations, for editors."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import click

from rigrunner.cli.options import lab_option
from rigrunner.cli.output import result_json

if TYPE_CHECKING:
    from rigrunner.workflow.schema import Language


@click.command(name="schema")
@click.argument("language", type=click.Choice(["procedure", "station"]))
@lab_option
def command(language: str, station: str | None) -> None:
    """Print the JSON Schema of procedures or stations, for editors.

    It knows the plugins that are installed; editors complete and check with it.
    """
    from rigrunner.cli.planning import lab_registry
    from rigrunner.workflow.schema import language_schema

    result_json(language_schema(cast("Language", language), lab_registry(station)))
