"""`rigrunner plugins`: list the installed plugins and their settings in YAML."""

from __future__ import annotations

from itertools import groupby
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.api.summaries import pairs
from rigrunner.cli.completing import plugin_names
from rigrunner.cli.options import lab_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.registry import Plugin, Registry


WIDTH, INDENT = 80, " " * 6


@click.command(name="plugins")
@click.argument("name", required=False, shell_complete=plugin_names)
@lab_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON, with each plugin's schema.")
def command(name: str | None, station: str | None, *, as_json: bool) -> None:
    """List the plugins and their settings.

    With the NAME of a plugin, show its settings in YAML.
    """
    from rigrunner.run.lab_plugins import lab_registry

    registry = lab_registry(station)
    if as_json:
        registry = registry.with_all_settings()
    plugins = [plugin for plugin in registry.plugins if name in (None, plugin.record.name)]
    if name is not None and not plugins:
        names = sorted({plugin.record.name for plugin in registry.plugins})
        hint = registry.suggestion(name, names)
        raise UsageError(f"there is no plugin '{name}'", hint=hint)
    if as_json:
        result_json([_document(plugin) for plugin in plugins])
    elif name is None:
        result("\n\n".join(_listing(registry)))
    else:
        result("\n\n".join(_details(plugin) for plugin in plugins))
    for disabled in registry.disabled:
        message(f"disabled: {disabled}")


def _listing(registry: Registry) -> Iterator[str]:
    """Yield the plugins of each kind and provider, in the order of use in a procedure."""
    place = {kind.name: place for place, kind in enumerate(registry.kinds)}
    plural = {kind.name: _words(kind.hook.partition("_")[2]) for kind in registry.kinds}
    plugins = sorted(
        registry.plugins, key=lambda each: (place.get(each.kind, len(place)), str(each.provider))
    )
    for (kind, provider), group in groupby(plugins, lambda each: (each.kind, str(each.provider))):
        rows = [(f"  {plugin.record.name}", plugin.record.help) for plugin in group]
        yield f"{plural.get(kind, _words(kind))} of {provider}\n{pairs(rows)}"


def _details(plugin: Plugin) -> str:
    """Return a plugin with each setting and its default as written in YAML."""
    from rigrunner.tools.schemas.fields import all_fields

    head = f"{_words(plugin.kind)} '{plugin.record.name}' of {plugin.provider}"
    lines = []
    for name, field in all_fields(plugin.record.settings_model):
        default = "(optional)" if field.default is None else _yaml(field.default)
        units = f" in {' or '.join(field.units)}" if field.units else ""
        bounds = f", {field.bounds}" if field.bounds else ""
        words = f"{field.help.rstrip('.')} ({field.kind}{units}{bounds})"
        lines.append(f"  {name}: {'(required)' if field.required else default}")
        lines.append(fill(words.strip(), WIDTH, initial_indent=INDENT, subsequent_indent=INDENT))
    return "\n".join([head, plugin.record.help, "", *(lines or ["no settings"])])


def _yaml(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_yaml(item) for item in value)}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _document(plugin: Plugin) -> dict[str, Any]:
    from rigrunner.tools.schemas.fields import all_fields
    from rigrunner.tools.schemas.settings import settings_schema

    record = plugin.record
    return {
        "kind": plugin.kind,
        "name": record.name,
        "help": record.help,
        "provider": plugin.provider.name,
        "version": plugin.provider.version,
        "parameters": [
            {
                "name": name,
                "kind": field.kind,
                "units": list(field.units),
                "bounds": field.bounds,
                "default": field.default,
                "required": field.required,
                "help": field.help,
            }
            for name, field in all_fields(record.settings_model)
        ],
        "settings": settings_schema(record.settings_model),
    }


def _words(kind: str) -> str:
    return kind.replace("_", " ")
