"""JSON Schema of the files that people write, so that editors check and complete them.

It is made from the models that read the files and from the settings of the installed plugins, so it
has each step, key and parameter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import TypeAdapter
from pydantic.json_schema import GenerateJsonSchema

from rigrunner.api.certificate import Certificate
from rigrunner.api.fit_choice import FitChoice
from rigrunner.api.hooks import StepRecord
from rigrunner.api.names import Name
from rigrunner.api.plugin_refs import LABEL, PluginRef
from rigrunner.certificate.letterhead import LetterheadFile
from rigrunner.certificate.order import Order
from rigrunner.procedure import AnalysisRef, Procedure
from rigrunner.procedure.acceptance import DecisionRuleRef
from rigrunner.procedure.kinds import KINDS, kinds_of, measurand_models
from rigrunner.procedure.result_limits import MEASURAND
from rigrunner.station import DeviceBinding, ListenerBinding, Station
from rigrunner.tools.importing.mapping import ImportMapping
from rigrunner.tools.schemas.fields import docstrings_of
from rigrunner.tools.schemas.settings import SettingsSchema
from rigrunner.tools.schemas.shapes import (
    SHARED,
    with_defaults_in_words,
    with_references,
    with_shared_choices,
    with_shared_quantities,
    without_unused,
)

if TYPE_CHECKING:
    from pydantic_core.core_schema import ModelSchema, PlainValidatorFunctionSchema

    from rigrunner.api.hooks import PluginRecord
    from rigrunner.api.settings import Settings
    from rigrunner.registry import Registry

Schema = dict[str, Any]
Language = Literal["procedure", "station", "import", "letterhead", "order"]

_MODELS: dict[str, type[Settings]] = {
    "procedure": Procedure,
    "station": Station,
    "import": ImportMapping,
    "letterhead": LetterheadFile,
    "order": Order,
}
DIALECT = "https://json-schema.org/draft/2020-12/schema"
PLUGIN = "x-plugin"
"""Marks, in the JSON Schema, a text that names a plugin; its value is the kind of plugin."""
RIG = "x-rig"
"""Marks, in the JSON Schema, the rig data of a station: the plugins declare its keys."""
LABELLED = "x-labelled"
"""Marks, in the JSON Schema, a text that names a plugin, or a use of it by its name from `as`."""
LABEL_TYPE = TypeAdapter(Name).core_schema


def certificate_schema() -> Schema:
    """Return the JSON Schema of certificates."""
    schema = Certificate.model_json_schema(
        mode="serialization", schema_generator=_CertificateSchema
    )
    return {"$schema": DIALECT, **schema}


def language_schema(language: Language, registry: Registry) -> Schema:
    """Return the JSON Schema of a language, with the plugins of the registry."""
    schema = _LanguageSchema(registry).generate(_MODELS[language].__pydantic_core_schema__)
    schema = with_shared_quantities(with_defaults_in_words(with_shared_choices(schema)))
    if language == "procedure":
        schema = with_references(schema, literal={"rigrunner", "parameters"})
    return {"$schema": DIALECT, **without_unused(schema)}


class _CertificateSchema(GenerateJsonSchema):
    """Describes each field by the docstring under it."""

    def model_schema(self, schema: ModelSchema) -> Schema:
        """Return the schema of a part, with the descriptions of its fields."""
        json_schema = super().model_schema(schema)
        for name, text in docstrings_of(schema["cls"]).items():
            json_schema["properties"][name]["description"] = text
        return json_schema


class _LanguageSchema(SettingsSchema):
    """Adds the plugins wherever a model names one."""

    def __init__(self, registry: Registry) -> None:
        super().__init__()
        self._registry = registry.with_all_settings()
        self._knows_steps = False

    def model_schema(self, schema: ModelSchema) -> Schema:
        """Return the schema of a model, with the plugins that it may name."""
        model = schema["cls"]
        if model is AnalysisRef:
            return self._analysis()
        json_schema = super().model_schema(schema)
        if issubclass(model, PluginRef | FitChoice):
            return self._name_or_settings(json_schema["description"], model)
        for spec in json_schema.get("properties", {}).values():
            if PLUGIN in spec:
                _name_plugins(spec, self._records(spec.pop(PLUGIN)))
            if spec.pop(MEASURAND, False):
                limits = measurand_models({KINDS: kinds_of(self._registry)})
                models = [self.generate_inner(model.__pydantic_core_schema__) for model in limits]
                if models:
                    del spec["type"], spec["additionalProperties"]
                    spec.update(models[0] if len(models) == 1 else {"anyOf": models})
            if spec.pop(RIG, False):
                keys = self._registry.rig_model()
                del spec["type"], spec["additionalProperties"]
                spec.update(self.generate_inner(keys.__pydantic_core_schema__))
        if issubclass(model, DeviceBinding):
            json_schema["allOf"] = [self._if_plugin(record) for record in self._records("device")]
        if issubclass(model, ListenerBinding) and self._records("event_sink"):
            json_schema["allOf"] = [self._if_plugin(each) for each in self._records("event_sink")]
        return json_schema

    def function_plain_schema(self, schema: PlainValidatorFunctionSchema) -> Schema:  # noqa: ARG002  (pydantic's signature)
        """Return the choice between all kinds of steps, by one key."""
        if self._knows_steps:
            return {SHARED: "Step"}
        self._knows_steps = True  # a sweep has steps
        steps = {}
        for record in self._records("step"):
            example = record.example if isinstance(record, StepRecord) else ""
            text = f"{record.help} `{example}`." if example else record.help
            steps[record.name] = self._settings(record) | {"description": text}
        return _one_key("Step", "A step: one key, which names the action.", steps)

    def _analysis(self) -> Schema:
        """Return the choice between all analyses, by one key."""
        inner = {
            record.name: self._settings(record) | {"description": record.help}
            for record in self._records("analysis")
        }
        choice = _one_key("", "An analysis: one key, which names it.", inner)
        del choice[SHARED]  # the model has a definition of its own
        return choice

    def _records(self, kind: str) -> list[PluginRecord]:
        by_name = {p.record.name: p.record for p in self._registry.plugins if p.kind == kind}
        return list(by_name.values())

    def _name_or_settings(self, description: str, model: type[PluginRef | FitChoice]) -> Schema:
        """Return the choice between a plugin's name, and its name with settings."""
        records = self._records(model.kind)
        settings = {
            record.name: self._settings(record) | {"description": record.help} for record in records
        }
        is_rule = issubclass(model, DecisionRuleRef)  # whose setting may be beside its name
        alone = _enumeration([each for each in records if is_rule or not _needs_settings(each)])
        label = self.generate_inner(LABEL_TYPE) | {"description": "Label of this use in results."}
        labelled = issubclass(model, PluginRef)
        with_settings = {
            "type": "object",
            "properties": {**settings, LABEL: label} if labelled else settings,
            "additionalProperties": False,
            "minProperties": 1,
            "maxProperties": 2 if labelled else 1,
        }
        return {"description": description, "anyOf": [alone, with_settings]}

    def _if_plugin(self, record: PluginRecord) -> Schema:
        """Return the schema of the settings where this plugin is named."""
        condition = {"properties": {"plugin": {"const": record.name}}, "required": ["plugin"]}
        then: Schema = {"properties": {"settings": self._settings(record)}}
        if _needs_settings(record):
            then["required"] = ["settings"]
        return {"if": condition, "then": then}

    def _settings(self, record: PluginRecord) -> Schema:
        return self.generate_inner(record.settings_model.__pydantic_core_schema__)


def _one_key(name: str, description: str, choices: dict[str, Schema]) -> Schema:
    """Return an object with exactly one key, defined once under a name.

    An editor then offers the keys, and names an unknown one.
    """
    return {
        SHARED: name,
        "type": "object",
        "description": description,
        "properties": choices,
        "additionalProperties": False,
        "minProperties": 1,
        "maxProperties": 1,
    }


def _needs_settings(record: PluginRecord) -> bool:
    return any(field.is_required() for field in record.settings_model.model_fields.values())


def _name_plugins(spec: Schema, records: list[PluginRecord]) -> None:
    """List the plugins that a text may name; where uses have labels, it may be a label as well."""
    if spec.pop(LABELLED, False):
        label = {"type": spec.pop("type"), "pattern": spec.pop("pattern")}
        spec["anyOf"] = [_enumeration(records), label]
    elif records:  # else any: one may be installed later
        spec.update(_enumeration(records))


def _enumeration(records: list[PluginRecord]) -> Schema:
    return {
        "type": "string",
        "enum": [record.name for record in records],
        "enumDescriptions": [record.help for record in records],
    }
