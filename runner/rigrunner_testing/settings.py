"""Checks on the declaration of every plugin: its name, its help line, its settings."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import PluginError
from rigrunner.api.units import kinds
from rigrunner.registry.records import PLUGIN_NAME
from rigrunner.tools.schemas.fields import all_fields, fields_of
from rigrunner.tools.schemas.settings import settings_schema
from rigrunner_testing.check import AnyCheck, Nonconformity, applies, check, demand

if TYPE_CHECKING:
    from rigrunner_testing.subjects import Subject

LONGEST_HELP = 100
NO_SUCH = "no_such_setting"
WRONG = ["a list", ["where none can be"]]


@check(needs=(), fix="give the record a name such as 'spring_scale'")
def name_fits_yaml(subject: Subject) -> None:
    """The name has small letters, digits and '_' only, so that YAML needs no quotes for it."""
    demand(re.fullmatch(PLUGIN_NAME, subject.name), f"the name is '{subject.name}'")


@check(needs=(), fix="write one line of at most 100 characters into the record's `help`")
def help_line(subject: Subject) -> None:
    """There is a help line, for the list of plugins."""
    text = subject.any_record.help
    demand(text.strip(), "the record's help is empty")
    demand("\n" not in text, "the record's help has several lines")
    demand(len(text) <= LONGEST_HELP, f"the record's help has {len(text)} characters")


@check(needs=(), fix="write a docstring under the field, or Annotated[..., Field(description=...)]")
def settings_explained(subject: Subject) -> None:
    """Every setting has a description, and editors get a JSON Schema of them."""
    model = subject.any_record.settings_model
    json.dumps(settings_schema(model))
    bare = [name for name, field in all_fields(model) if not field.help.strip()]
    demand(not bare, f"no word of help on: {', '.join(bare)}")


@check(
    needs=(),
    fix="derive the settings from rigrunner.api.settings.Settings, which forbids other keys",
)
def unknown_setting_refused(subject: Subject) -> None:
    """An unknown setting, such as a misspelt one, is refused by its name."""
    _check_refused(subject, NO_SUCH, 1, {**subject.settings, NO_SUCH: 1})


@check(needs=(), fix="annotate the field with its type, and let validators raise ValueError alone")
def wrong_type_refused(subject: Subject) -> None:
    """A value of the wrong type is refused, naming the setting."""
    fields = [
        field
        for field in fields_of(subject.any_record.settings_model)
        if not any(word in field.kind for word in ("anything", "object"))
    ]
    applies(fields, "it has no settings of a type")
    for field in fields:
        _check_refused(subject, field.key, WRONG, {**subject.settings, field.key: WRONG})


@check(needs=(), fix="annotate quantities with the types of rigrunner.api.settings: `load: Force`")
def wrong_unit_refused(subject: Subject) -> None:
    """A quantity of another kind, or a number without a unit, is refused, naming the setting."""
    fields = [field for field in fields_of(subject.any_record.settings_model) if field.units]
    quantities = [field for field in fields if not field.entry and field.kind in kinds()]
    applies(quantities, "it has no settings with units")
    for field in quantities:
        for value in ("3 N" if field.kind == "mass" else "3 kg", 12345.678):
            _check_refused(subject, field.key, value, {**subject.settings, field.key: value})


def _check_refused(subject: Subject, key: str, value: object, settings: dict[str, Any]) -> None:
    try:
        subject.registry.validated(subject.kind, subject.name, settings)
    except PluginError as error:
        is_named = key in str(error)
        demand(is_named, f"'{key}: {value}' is refused without naming '{key}': {error}")
    except Exception as error:
        raise Nonconformity(f"'{key}: {value}' gives {type(error).__name__}: {error}") from error
    else:
        raise Nonconformity(f"'{key}: {value}' is taken")


CHECKS: tuple[AnyCheck, ...] = (
    name_fits_yaml,
    help_line,
    settings_explained,
    unknown_setting_refused,
    wrong_type_refused,
    wrong_unit_refused,
)
