"""Change a JSON Schema so that editors complete and check better than with pydantic's.

Each function takes a whole schema with its definitions and returns a new one.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

Schema = dict[str, Any]

SHARED = "x-shared"
"""Marks, in the JSON Schema, a choice that is defined once; its value is its name."""
DIMENSION = "x-dimension"
"""Marks, in the JSON Schema, a quantity; its value is its dimension, or None for any."""
_DEFINITIONS = "$defs"
_POINTER = "#/$defs/"
_REFERENCE = r"^\$[A-Za-z][A-Za-z0-9_]*$"
_WORDS = {
    "integer": "a whole number",
    "number": "a number",
    "boolean": "true or false",
    "array": "a list",
}


def with_shared_choices(schema: Schema) -> Schema:
    """Define each choice by one key once, and refer to it by `SHARED` elsewhere."""
    shared: dict[str, Schema] = {}

    def change(node: Schema) -> Schema:
        if SHARED not in node:
            return node
        name = node[SHARED]
        if "properties" in node:
            shared[name] = {key: node[key] for key in node if key != SHARED}
        return {"$ref": f"{_POINTER}{name}"}

    changed: Schema = _map_nodes(schema, change)
    changed[_DEFINITIONS] |= shared
    return changed


def with_defaults_in_words(schema: Schema) -> Schema:
    """Move each default into the description: an editor would insert it where it is not needed."""

    def change(node: Schema) -> Schema:
        if "default" not in node:
            return node
        kept = {key: node[key] for key in node if key != "default"}
        default = json.dumps(node["default"], ensure_ascii=False).strip('"')
        return {**kept, "description": f"{node.get('description', '')} Default: {default}.".strip()}

    changed: Schema = _map_nodes(schema, change)
    return changed


def with_shared_quantities(schema: Schema) -> Schema:
    """Define each kind of quantity once, under the name of its dimension."""
    shared: dict[str, Schema] = {}

    def change(node: Schema) -> Schema:
        if DIMENSION not in node:
            return node
        name = node[DIMENSION] or "quantity"
        local = {key: node[key] for key in node if key in {"description", "default"}}
        shared[name] = {key: node[key] for key in node if key not in {*local, DIMENSION}}
        return {"$ref": _POINTER + name.replace(" ", "_"), **local}

    changed: Schema = _map_nodes(schema, change)
    changed[_DEFINITIONS] |= {name.replace(" ", "_"): shared[name] for name in sorted(shared)}
    return changed


def with_references(schema: Schema, literal: Collection[str]) -> Schema:
    """Allow '$name' for every value, except under the top-level keys in `literal`."""
    literals = {key: schema["properties"][key] for key in literal}
    changed: Schema = _map_nodes(schema, _with_reference)
    changed["properties"] |= literals
    return changed


def _with_reference(node: Schema) -> Schema:
    kind = node.get("type")
    if "anyOf" in node:
        flat = [part for option in node["anyOf"] for part in option.get("anyOf", [option])]
        return {**node, "anyOf": flat}
    if "enum" in node:
        choice = {key: node[key] for key in node if key != "description"}
        description = {"description": node["description"]} if "description" in node else {}
        return {**description, "anyOf": [choice, {"type": "string", "pattern": _REFERENCE}]}
    if kind == "string" and "pattern" in node:
        return {**node, "pattern": f"{_REFERENCE}|{node['pattern']}"}
    if kind in {"integer", "number", "boolean", "array"}:
        words = f"expected {_WORDS[kind]}, or $name for a parameter"
        change = {"type": [kind, "string"], "pattern": _REFERENCE, "patternErrorMessage": words}
        return {**node, **change}
    return node


def without_unused(schema: Schema) -> Schema:
    """Remove the definitions that nothing refers to."""
    definitions = schema[_DEFINITIONS]
    used: dict[str, Schema] = {}
    waiting = list(_targets({**schema, _DEFINITIONS: {}}))
    while waiting:
        name = waiting.pop()
        if name not in used:
            used[name] = definitions[name]
            waiting += _targets(used[name])
    return {**schema, _DEFINITIONS: {name: used[name] for name in definitions if name in used}}


def _map_nodes(node: Any, change: Callable[[Schema], Schema]) -> Any:
    """Return a copy of a tree with every mapping in it changed, the innermost first."""
    if isinstance(node, list):
        return [_map_nodes(item, change) for item in node]
    if not isinstance(node, dict):
        return node
    return change({key: _map_nodes(value, change) for key, value in node.items()})


def _targets(node: Any) -> Iterator[str]:
    if isinstance(node, dict):
        if isinstance(target := node.get("$ref"), str):  # no mapping: a key of that name
            yield target.removeprefix(_POINTER)
        for value in node.values():
            yield from _targets(value)
    elif isinstance(node, list):
        for item in node:
            yield from _targets(item)
