"""The analyses that a procedure asks for: a list, each a mapping with one key, its name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, ValidationInfo, model_validator

from rigrunner.api.errors import PluginError
from rigrunner.api.member import NAME
from rigrunner.api.plugin_refs import PluginRef
from rigrunner.api.settings import ListOf, Settings
from rigrunner.procedure.kinds import KINDS, STORED, installed_kinds, read_with_key
from rigrunner.procedure.refusals import refusal

if TYPE_CHECKING:
    from collections.abc import Mapping


class AnalysisRef(PluginRef):
    """An analysis, a plugin: `name: {setting: value}`."""

    kind = "analysis"

    @classmethod
    def inside(cls, name: str) -> type[Settings] | None:
        """Return the model under a key that names an analysis; None for any other."""
        return _settings_model(name, {})

    @model_validator(mode="before")
    @classmethod
    def _one_key(cls, value: object, info: ValidationInfo) -> object:
        """Refuse what is no mapping with one key that can name an analysis, and wrong settings.

        An analysis that is not known here may be brought by a plugin of the station.
        """
        mapping = value if isinstance(value, dict) else {}
        keys = [str(key) for key in mapping]
        if len(keys) != 1:
            got = " and ".join(f"'{key}'" for key in keys[:5])
            raise refusal(
                "an analysis is a mapping with one key, such as 'equation: ...'",
                f"got {got}: begin each analysis with its own '-'" if got else "",
            )
        if not re.fullmatch(NAME, keys[0]):
            raise refusal(f"unknown analysis '{keys[0][:40]}', expected the name of a plugin")
        model = _settings_model(keys[0], info.context or {})
        settings = mapping[keys[0]] or {}
        if model is not None and isinstance(settings, dict):
            read_with_key(keys[0], model, settings)
        return value


class AnalysisFile(Settings):
    """A file that replaces what the procedure of a run has: to analyse it in another way.

    What it does not name stays.
    """

    rigrunner: Literal["analysis/1"]
    """Type and version of this file."""
    analysis: dict[str, Any] = Field(default_factory=dict)
    """Settings of the analysis that gives the procedure's measurand."""
    named: ListOf[AnalysisRef] = ()
    """In place of all analyses that name their results; none: they stay."""


def _settings_model(name: str, context: Mapping[str, Any]) -> type[Settings] | None:
    """Return the model of the settings; None where they are not checked.

    A stored run may have been analysed by a plugin in another version.
    """
    if context.get(STORED):
        return None
    record = (context.get(KINDS) or installed_kinds()).analyses.get(name)
    try:
        return None if record is None else record.settings_model
    except PluginError:
        return None  # reported by the check of the plugins
