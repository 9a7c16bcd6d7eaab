"""`rigrunner schema`: JSON Schema of procedures, stations, mappings and certificates."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import click

from rigrunner.cli.options import lab_option
from rigrunner.cli.output import result_json

if TYPE_CHECKING:
    from rigrunner.tools.schemas.files import Language


KINDS = ["procedure", "station", "import", "letterhead", "order", "certificate"]


@click.command(name="schema")
@click.argument("language", type=click.Choice(KINDS))
@lab_option
def command(language: str, station: str | None) -> None:
    """Print the JSON Schema of procedures, stations and other files.

    Schemas of procedures, stations and imports include the installed plugins.
    """
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.tools.schemas.files import certificate_schema, language_schema

    if language == "certificate":
        result_json(certificate_schema())
    else:
        result_json(language_schema(cast("Language", language), lab_registry(station)))
