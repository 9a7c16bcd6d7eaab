"""JSON Schema of settings as a person writes them: quantities as text, with help."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic.json_schema import GenerateJsonSchema

from rigrunner.tools.schemas.fields import fields_of

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic_core.core_schema import (
        DictSchema,
        ModelSchema,
        NullableSchema,
        PlainValidatorFunctionSchema,
        WithDefaultSchema,
    )

Schema = dict[str, Any]


class SettingsSchema(GenerateJsonSchema):
    """pydantic's schema of a model, with defaults in YAML and without titles."""

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ARG002  (pydantic's signature)
        """Leave out titles: they repeat the key."""
        return False

    def default_schema(self, schema: WithDefaultSchema) -> Schema:
        """Leave out pydantic's default: `model_schema` writes it as in YAML."""
        return self.generate_inner(schema["schema"])

    def nullable_schema(self, schema: NullableSchema) -> Schema:
        """Leave out null: an unused key is not written."""
        return self.generate_inner(schema["schema"])

    def function_plain_schema(self, schema: PlainValidatorFunctionSchema) -> Schema:  # noqa: ARG002  (pydantic's signature)
        """Take a value that a function alone reads for a mapping: it is a step."""
        return {"type": "object"}

    def dict_schema(self, schema: DictSchema) -> Schema:
        """Refuse a key that does not match the pattern of the keys."""
        json_schema = super().dict_schema(schema)
        if "patternProperties" in json_schema:
            json_schema["additionalProperties"] = False
        return json_schema

    def model_schema(self, schema: ModelSchema) -> Schema:
        """Return the schema of a model, with the description of each key."""
        json_schema = super().model_schema(schema)
        json_schema.pop("title", None)
        described = {field.key: field for field in fields_of(schema["cls"])}
        for key, spec in json_schema.get("properties", {}).items():
            field = described[key]
            sentences = [_sentence(field.help)]
            if field.units:  # of all others the schema has kind and bounds
                bounds = f", {field.bounds}" if field.bounds else ""
                sentences.append(_sentence(f"{field.kind} in {' or '.join(field.units)}{bounds}"))
            spec.pop("description", None)
            if any(sentences):
                spec["description"] = " ".join(filter(None, sentences))
            if field.default is not None:
                spec["default"] = field.default
        return json_schema


def settings_schema(model: type[BaseModel]) -> Schema:
    """Return the JSON Schema of a plugin's settings."""
    return SettingsSchema().generate(model.__pydantic_core_schema__)


def _sentence(text: str) -> str:
    text = text.strip().rstrip(".")
    return f"{text[0].upper()}{text[1:]}." if text else ""
