"""`rigrunner plugins`: list the installed plugins and their settings in YAML."""

from __future__ import annotations

from itertools import groupby
from textwrap import fill
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import UsageError
from rigrunner.api.summaries import pairs
from rigrunner.cli.brief import brief_command
from rigrunner.cli.completing import plugin_names
from rigrunner.cli.options import lab_option
from rigrunner.cli.output import message, result, result_json

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.registry import Plugin, Registry
    from rigrunner.tools.schemas.fields import Field

WIDTH = 80


@click.command(name="plugins")
@click.argument("name", required=False, shell_complete=plugin_names)
@lab_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON, with each plugin's schema.")
def command(name: str | None, station: str | None, *, as_json: bool) -> None:
    """List the plugins and their settings.

    With the NAME of a plugin, show its settings in YAML.
    """
    with brief_command():
        _show(name, station, as_json=as_json)


def _show(name: str | None, station: str | None, *, as_json: bool) -> None:
    from rigrunner.run.lab_plugins import lab_registry

    registry = lab_registry(station)
    if as_json:
        registry = registry.with_all_settings()
    plugins = [plugin for plugin in registry.plugins if name in (None, plugin.record.name)]
    if name is not None and not plugins:
        raise _unknown(registry, name)
    if as_json:
        result_json([_document(plugin) for plugin in plugins])
    elif name is None:
        result("\n\n".join(_listing(registry)))
    else:
        result("\n\n".join(_details(plugin) for plugin in plugins))
    for disabled in registry.disabled:
        message(f"disabled: {disabled}")


def _unknown(registry: Registry, name: str) -> UsageError:
    names = sorted({plugin.record.name for plugin in registry.plugins})
    return UsageError(f"there is no plugin '{name}'", hint=registry.suggestion(name, names))


def _listing(registry: Registry) -> Iterator[str]:
    """Yield the plugins of each kind and provider, in the order of use in a procedure."""
    place = {kind.name: place for place, kind in enumerate(registry.kinds)}
    plural = {kind.name: _words(kind.hook.partition("_")[2]) for kind in registry.kinds}
    plugins = sorted(
        registry.plugins, key=lambda each: (place.get(each.kind, len(place)), _provider(each))
    )
    for (kind, provider), group in groupby(plugins, lambda each: (each.kind, _provider(each))):
        rows = [(f"  {plugin.record.name}", plugin.record.help) for plugin in group]
        yield f"{plural.get(kind, _words(kind))} of {provider}\n{pairs(rows)}"


def _details(plugin: Plugin) -> str:
    head = f"{_words(plugin.kind)} '{plugin.record.name}' of {_provider(plugin)}"
    from rigrunner.tools.schemas.fields import all_fields

    settings = [_setting(name, field) for name, field in all_fields(plugin.record.settings_model)]
    return "\n".join([head, plugin.record.help, "", *(settings or ["no settings"])])


def _setting(name: str, field: Field) -> str:
    """Return a setting with its default as written in YAML, and its help."""
    units = f" in {' or '.join(field.units)}" if field.units else ""
    bounds = f", {field.bounds}" if field.bounds else ""
    words = f"{field.help.rstrip('.')} ({field.kind}{units}{bounds})"
    indent = " " * 6
    about = fill(words.strip(), WIDTH, initial_indent=indent, subsequent_indent=indent)
    return f"  {name}: {_default(field)}\n{about}"


def _default(field: Field) -> str:
    if field.required:
        return "(required)"
    return "(optional)" if field.default is None else _yaml(field.default)


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
            _parameter(name, field) for name, field in all_fields(record.settings_model)
        ],
        "settings": settings_schema(record.settings_model),
    }


def _parameter(name: str, field: Field) -> dict[str, Any]:
    return {
        "name": name,
        "kind": field.kind,
        "units": list(field.units),
        "bounds": field.bounds,
        "default": field.default,
        "required": field.required,
        "help": field.help,
    }


def _provider(plugin: Plugin) -> str:
    return str(plugin.provider)


def _words(kind: str) -> str:
    return kind.replace("_", " ")
