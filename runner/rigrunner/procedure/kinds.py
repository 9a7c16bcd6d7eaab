"""The kinds of steps and the analyses that a procedure may name, and their settings."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from pydantic_core import SchemaValidator, core_schema

from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import AnalysisRecord, StepRecord
from rigrunner.registry import load_registry

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.settings import Settings
    from rigrunner.registry import Registry

KINDS = "kinds"
"""The key of the Kinds in the context of a validation."""

STORED = "stored"
"""The key in it that says that the text is of a stored run, whose plugins may be missing here."""

ASKED = "asked"
"""The key in it of the names of the analyses that a procedure asks for."""


@dataclass(frozen=True)
class Kinds:
    """What a procedure may name, by name."""

    steps: Mapping[str, StepRecord]
    analyses: Mapping[str, AnalysisRecord]


def kinds_of(registry: Registry) -> Kinds:
    """Return what a registry has; raise PluginError where two plugins bring one kind of step.

    Two analyses of one name are reported by the check of the plugins.
    """
    steps = (registry.find("step", name).record for name in registry.names("step"))
    records = (plugin.record for plugin in registry.plugins)
    return Kinds(
        {step.name: step for step in steps if isinstance(step, StepRecord)},
        {record.name: record for record in records if isinstance(record, AnalysisRecord)},
    )


@cache
def installed_kinds() -> Kinds:
    """Return what is installed: for a procedure whose station is not known."""
    return kinds_of(load_registry())


def measurand_models(context: Mapping[str, Any]) -> tuple[type[Settings], ...]:
    """Return the models of the key `measurand` of limits, of the analyses that are asked for.

    Of all that are known where the context of the validation does not say which are asked for.
    """
    analyses = (context.get(KINDS) or installed_kinds()).analyses
    records = [analyses[name] for name in context.get(ASKED, analyses) if name in analyses]
    models: dict[type[Settings], None] = {}
    for record in records:
        # Else the key is kept as written, and refused where it is applied to a result.
        with suppress(PluginError):
            if record.limit_measurand_model is not None:
                models[record.limit_measurand_model] = None
    return tuple(models)


def read_with_key(key: str, model: type[Settings], value: object, context: Any = None) -> Any:
    """Return the settings under a key; raise ValidationError, in which places begin with the key.

    The settings may be a model of `model`, or what a file has.
    """
    return _reader(key, model).validate_python({key: value}, context=context)[key]


@cache
def _reader(key: str, model: type[Settings]) -> SchemaValidator:
    # Models of settings are built when they are first used, and this one may be the first use.
    model.model_rebuild()
    field = core_schema.typed_dict_field(model.__pydantic_core_schema__)
    return SchemaValidator(core_schema.typed_dict_schema({key: field}))
