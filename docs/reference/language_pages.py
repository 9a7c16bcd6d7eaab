#!/usr/bin/env python3
"""Lists every key of the languages, from their schemas, which are made from the models.

    python docs/reference/language_pages.py docs/reference

Writes `keys-of-a-procedure.md`, `keys-of-a-station.md` and `keys-of-an-import.md`.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

PROCEDURES = Path(__file__).parents[2] / "procedures"
LANGUAGES = {"procedure": "a procedure", "station": "a station", "import": "an import"}
HEAD = """# Every key of {what}

Made by `docs/reference/language_pages.py` from `procedures/{name}.schema.json`,
which `rigrunner schema {name}` makes from the models and from the plugins that ship. {more}

A key that is not *needed* may be left out. A quantity is a text with a unit, such as `10 Hz`. Where
a file has parameters, `$name` may stand wherever a value may.
"""
MORE = {
    "procedure": "[The language](procedure-language.md) explains them.",
    "station": "[The station](procedure-language.md#the-station) explains them.",
    "import": "[The mapping](import-mapping.md) explains them.",
}
LONG = ("rigrunner_plugins__devices__", "settings__", "text__patterns__")
SIMPLE = {
    "string": "text",
    "integer": "whole number",
    "number": "number",
    "boolean": "`yes` or `no`",
}
Schema = dict[str, Any]


@dataclass(frozen=True)
class Language:
    """A schema, and what its definitions are called on the page."""

    name: str
    what: str

    @cached_property
    def schema(self) -> Schema:
        """The committed schema."""
        text = (PROCEDURES / f"{self.name}.schema.json").read_text(encoding="utf-8")
        return dict(json.loads(text))

    def page(self) -> str:
        """Return the page."""
        sections = [HEAD.format(name=self.name, what=self.what, more=MORE[self.name])]
        sections.append(f"## {_capital(self.what)}\n\n{self._body(self.schema)}")
        sections += [
            f"## {_title(each)}\n\n{self._body(self.schema['$defs'][each])}"
            for each in self._reached()
        ]
        return "\n".join(sections)

    def _reached(self) -> list[str]:
        """Return the definitions that have a section, in the order in which they are met."""
        found: list[str] = []
        todo = _references(self.schema, skip="$defs")
        while todo:
            name = todo.pop(0)
            if name not in found and self._has_section(name):
                found.append(name)
                todo = _references(self.schema["$defs"][name]) + todo
        return found

    def _has_section(self, name: str) -> bool:
        return bool({"properties", "anyOf"} & set(self.schema["$defs"][name]))

    def _body(self, schema: Schema) -> str:
        parts = [schema.get("description", "")]
        mapping = schema
        for each in schema.get("anyOf", ()):
            if "enum" in each:
                parts.append(f"Its name alone: {_choices(each['enum'])}; or a mapping:")
            mapping = each if "properties" in each else mapping
        if mapping.get("properties"):
            parts.append(self._table(mapping))
        parts += [
            f"Any other key is a name, and its value {self._value(pattern)}."
            for pattern in mapping.get("patternProperties", {}).values()
        ]
        chosen = [line for each in schema.get("allOf", ()) for line in self._chosen(each)]
        if chosen:
            parts.append("| where | is |\n|---|---|\n" + "\n".join(chosen))
        return "\n\n".join(part for part in parts if part) + "\n"

    def _table(self, schema: Schema) -> str:
        needed = schema.get("required", ())
        rows = ["| key | needed | value | what it is |", "|---|---|---|---|"]
        for key, each in schema["properties"].items():
            need = "needed" if key in needed else ""
            rows.append(f"| `{key}` | {need} | {self._value(each)} | {self._told(each)} |")
        return "\n".join(rows)

    def _told(self, schema: Schema) -> str:
        given = schema.get("description") or self._target(schema).get("description", "")
        return _cell(given)

    def _chosen(self, rule: Schema) -> list[str]:
        """Return rows for what a key must be where another one has some value."""
        where = rule.get("if", {}).get("properties", {})
        then = rule.get("then", {}).get("properties", {})
        condition = ", ".join(
            f"`{key}: {subschema['const']}`"
            for key, subschema in where.items()
            if "const" in subschema
        )
        return [
            f"| {condition} | `{key}`: {self._value(each)} |"
            for key, each in then.items()
            if condition
        ]

    def _target(self, schema: Schema) -> Schema:
        name = schema.get("$ref", "").rpartition("/")[2]
        return dict(self.schema["$defs"].get(name, {}))

    def _value(self, schema: Schema) -> str:
        """Return what may stand there, in words."""
        if "$ref" in schema:
            return self._named(schema["$ref"].rpartition("/")[2])
        if "const" in schema or "enum" in schema:
            return _choices(schema.get("enum", [schema.get("const")]))
        if "patternProperties" in schema:
            return f"names, each with {self._one_of(schema['patternProperties'].values())}"
        several = schema.get("anyOf") or schema.get("oneOf")
        return self._one_of(several) if several else self._of_type(schema)

    def _named(self, name: str) -> str:
        title = _title(name)
        if not self._has_section(name):  # a quantity
            return title.replace("_", " ")
        return f"[{title}](#{title.lower().replace(' ', '-')})"

    def _one_of(self, schemas: Iterable[Schema]) -> str:
        values = [self._value(each) for each in schemas if not _is_parameter(each)]
        return " or ".join(dict.fromkeys(values))

    def _of_type(self, schema: Schema) -> str:
        types = schema.get("type", "")
        first = types[0] if isinstance(types, list) else types
        if first == "array":
            return f"list of {self._value(schema.get('items', {}))}"
        return SIMPLE.get(first, "mapping" if first == "object" else "any") + _range(schema)


def _references(schema: Any, skip: str = "") -> list[str]:
    if isinstance(schema, dict):
        own = [schema["$ref"].rpartition("/")[2]] if "$ref" in schema else []
        inner = [_references(each) for key, each in schema.items() if key != skip]
        return own + [name for names in inner for name in names]
    if isinstance(schema, list):
        return [name for each in schema for name in _references(each)]
    return []


def _is_parameter(schema: Schema) -> bool:
    return str(schema.get("pattern", "")) == "^\\$[A-Za-z][A-Za-z0-9_]*$"


def _choices(values: list[Any]) -> str:
    """Return them without True and False, which are what YAML may make of yes and no."""
    return ", ".join(f"`{value}`" for value in values if not isinstance(value, bool))


def _range(schema: Schema) -> str:
    ends = {"minimum": "at least", "exclusiveMinimum": "more than", "maximum": "at most"}
    parts = [f"{text} {schema[key]}" for key, text in ends.items() if key in schema]
    return f", {', '.join(parts)}" if parts else ""


def _title(name: str) -> str:
    for part in LONG:
        name = name.replace(part, " " if name.rpartition(part)[0] else "")
    return " ".join(name.removesuffix("Step").replace("__", " ").split()) or name


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def pages() -> dict[str, str]:
    """Return the pages by their file names."""
    return {
        f"keys-of-{what.replace(' ', '-')}.md": Language(name, what).page()
        for name, what in LANGUAGES.items()
    }


def main(folder: Path) -> None:
    """Write the pages."""
    for name, text in pages().items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
