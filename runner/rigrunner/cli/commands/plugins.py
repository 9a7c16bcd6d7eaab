"""`rigrunner plugins`: what is installed, and what each plugin can be told in YAML."""

from __future__ import annotations

import difflib
from typing import Any

import click

from rigrunner.api.errors import PluginError
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.table import pairs
from rigrunner.registry import HOOK_OF_KIND, Plugin, Registry, load_registry


@click.command(name="plugins")
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print JSON, with each plugin's schema.")
def command(name: str | None, *, as_json: bool) -> None:
    """List the plugins and what each can be told.

    With the NAME of a plugin, show its settings as they may stand in YAML.
    """
    registry = load_registry()
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
        message(f"disabled: {disabled.provider}: {disabled.reason}")


def _unknown(registry: Registry, name: str) -> PluginError:
    names = sorted({plugin.record.name for plugin in registry.plugins})
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"did you mean '{near[0]}'?" if near else f"there are: {', '.join(names) or 'none'}"
    return PluginError(f"there is no plugin '{name}'", hint=hint)


def _listing(registry: Registry) -> list[str]:
    sections = []
    for kind in HOOK_OF_KIND:
        rows = [(f"  {p.record.name}", p.record.help) for p in registry.plugins if p.kind == kind]
        if rows:
            sections.append(f"{_words(kind)}s\n{pairs(rows)}")
    return sections


def _details(plugin: Plugin) -> str:
    head = f"{_words(plugin.kind)} '{plugin.record.name}' of {plugin.provider}"
    schema = plugin.record.settings.model_json_schema()
    required = set(schema.get("required", ()))
    rows = [
        (f"  {name}", _setting(spec, required=name in required))
        for name, spec in schema.get("properties", {}).items()
    ]
    return f"{head}\n{plugin.record.help}\n\n{pairs(rows) if rows else '  nothing to set'}"


def _setting(spec: dict[str, Any], *, required: bool) -> str:
    words = spec.get("description") or str(spec.get("type", ""))
    choices = spec.get("enum")
    said = " | ".join(str(choice) for choice in choices) if choices else words
    return f"{said} (required)" if required else f"{said} (default: {spec.get('default')})"


def _document(plugin: Plugin) -> dict[str, Any]:
    return {
        "kind": plugin.kind,
        "name": plugin.record.name,
        "help": plugin.record.help,
        "provider": plugin.provider.name,
        "version": plugin.provider.version,
        "settings": plugin.record.settings.model_json_schema(),
    }


def _words(kind: str) -> str:
    return kind.replace("_", " ")
