"""`rigrunner plugins`: what is installed, and what each plugin can be told in YAML."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING, Any

import click

from rigrunner.api.errors import PluginError
from rigrunner.cli.output import message, result, result_json
from rigrunner.cli.table import pairs
from rigrunner.registry import HOOK_OF_KIND, Plugin, Registry, load_registry

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    Schema = Mapping[str, Any]


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
    rows = [(f"  {name}", said) for name, said in _settings(schema, schema.get("$defs", {}))]
    return f"{head}\n{plugin.record.help}\n\n{pairs(rows) if rows else '  nothing to set'}"


def _settings(schema: Schema, models: Schema, within: str = "") -> Iterator[tuple[str, str]]:
    """Yield each setting by its dotted name, those of nested models too, and what it may be."""
    required = schema.get("required", ())
    for name, spec in schema.get("properties", {}).items():
        nested = models.get(spec.get("$ref", "").rpartition("/")[2])
        if nested is None:
            yield f"{within}{name}", _setting(spec, required=name in required)
        else:
            yield from _settings(nested, models, f"{within}{name}.")


def _setting(spec: Schema, *, required: bool) -> str:
    words = spec.get("description") or str(spec.get("type", ""))
    choices = spec.get("enum")
    said = " | ".join(str(choice) for choice in choices) if choices else words
    ending = "required" if required else f"default: {spec.get('default')}"
    return f"{said} ({ending})"


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
