"""The analyses that a procedure asks for: a list, each a mapping with one key, its name."""

from __future__ import annotations

import re

from pydantic import model_validator

from rigrunner.api.member import NAME
from rigrunner.api.plugin_refs import PluginRef
from rigrunner.procedure.refusals import refused


class AnalysisRef(PluginRef):
    """An analysis, a plugin: `name: {setting: value}`."""

    kind = "analysis"

    @model_validator(mode="before")
    @classmethod
    def _one_key(cls, value: object) -> object:
        """Refuse what is no mapping with one key that can name an analysis.

        Whether a plugin has that name is asked where the plugins are known.
        """
        keys = [str(key) for key in value] if isinstance(value, dict) else []
        if len(keys) != 1:
            got = " and ".join(f"'{key}'" for key in keys[:5])
            raise refused(
                "an analysis is a mapping with one key, such as 'equation: ...'",
                f"got {got}: begin each analysis with its own '-'" if got else "",
            )
        if not re.fullmatch(NAME, keys[0]):
            raise refused(f"unknown analysis '{keys[0][:40]}', expected the name of a plugin")
        return value
