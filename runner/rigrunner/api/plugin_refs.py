"""Plugins that settings name: `grubbs`, or `{grubbs: {alpha: 0.05}}`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails

from rigrunner.api.fit_choice import FitChoice
from rigrunner.api.names import Name, Text
from rigrunner.api.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Iterator

LABEL = "as"
"""The key that names one use of a plugin, so that it can be used twice."""


class PluginRef(Settings):
    """A plugin by its name, with settings or without: `grubbs` or `{grubbs: {alpha: 0.05}}`.

    A subclass sets `kind`. Settings with fields of such a class, or with lists of it, name plugins:
    `check` looks at these and at their settings too, and runs record their revisions.
    """

    kind: ClassVar[str]
    """The kind of plugin that is named, as the registry has it."""
    name: Text
    """Of the plugin."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Its settings."""
    label: Annotated[Name, Field(alias=LABEL)]
    """How results name it: `as`, or else the plugin's own name."""

    @model_validator(mode="before")
    @classmethod
    def _read(cls, value: object) -> object:
        if isinstance(value, str):
            return {"name": value, LABEL: value}
        names = [key for key in value if key != LABEL] if isinstance(value, dict) else []
        if not isinstance(value, dict) or len(names) != 1:
            raise ValueError("a plugin is written as 'name', or as 'name: {setting: value}'")
        settings = value[names[0]]
        if not isinstance(settings, dict | None):
            # placed where the settings stand
            details = InitErrorDetails(type="dict_type", loc=(names[0],), input=settings)
            raise ValidationError.from_exception_data(cls.__name__, [details])
        return {"name": names[0], "settings": settings or {}, LABEL: value.get(LABEL, names[0])}


class OutlierRuleRef(PluginRef):
    """A rule for gross errors: by its name, or as `name: {setting: value}`."""

    kind = "outlier_rule"


class FitRef(PluginRef):
    """A fit of y over x: by its name, or as `name: {setting: value}`."""

    kind = "fit"


def plugins_in(settings: Settings) -> Iterator[tuple[tuple[str | int, ...], PluginRef | FitChoice]]:
    """Yield the plugins that settings name, in the order of the fields, each with its place."""
    for field, value in settings:
        if isinstance(value, PluginRef | FitChoice):
            yield (field,), value
        elif isinstance(value, tuple):
            for index, item in enumerate(value):
                if isinstance(item, PluginRef):
                    yield (field, index), item
