"""The analyses that a procedure asks for: a list, each a mapping with one key, its name."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from pydantic_core import SchemaValidator, core_schema

from rigrunner.api.errors import did_you_mean
from rigrunner.api.member import NAME
from rigrunner.procedure.analysis_spec import (
    STARTS,
    SWINGS,
    AnalysisSpec,
    NamedAnalysisRef,
    StartsSpec,
    TorqueAnalysis,
)
from rigrunner.procedure.refusals import refused

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler


class SwingTorque(TorqueAnalysis):
    """Torque at the reversals of swings, from recordings or from measured values."""


class Breakaway(TorqueAnalysis, StartsSpec):
    """Torque at the first movement: every recording is a start from rest."""


ANALYSES: dict[str, type[TorqueAnalysis]] = {SWINGS: SwingTorque, STARTS: Breakaway}
"""The analyses of torque, by their names in procedures; any other is a plugin's."""
READS = "reads"
"""The key in the metadata of a schema that says what a function reads."""


@dataclass(frozen=True)
class AnalysisRef:
    """One analysis: its name, and what it is told."""

    name: str
    settings: AnalysisSpec
    """Of torque; of any other it asks nothing."""
    plugin: NamedAnalysisRef | None = None
    """The plugin that makes it, of any other than of torque."""

    @classmethod
    def inside(cls, name: str) -> type[TorqueAnalysis] | None:
        """Return the model under a key that names an analysis; None for any other."""
        return ANALYSES.get(name)

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Let a model read it."""
        return core_schema.no_info_plain_validator_function(_read, metadata={READS: "analysis"})


def _read(value: Any) -> AnalysisRef:
    if isinstance(value, AnalysisRef):
        return value
    name = _one_key(value)
    if name not in ANALYSES:
        return AnalysisRef(name, AnalysisSpec(), NamedAnalysisRef.model_validate(value))
    read = _reader(name).validate_python(value)[name]
    told = {each: getattr(read, each) for each in read.model_fields_set}
    if isinstance(read, Breakaway):
        of_starts = {each: told.pop(each) for each in StartsSpec.model_fields if each in told}
        told["starts"] = StartsSpec().model_copy(update=of_starts)
    return AnalysisRef(name, AnalysisSpec().model_copy(update=told))


def _one_key(value: object) -> str:
    """Return the one key; refuse what is no mapping with one key that can name an analysis.

    Whether a plugin has that name is asked where the plugins are known.
    """
    known = f"expected one of: {', '.join(ANALYSES)}, or the name of a plugin"
    keys = [str(key) for key in value] if isinstance(value, dict) else []
    if len(keys) != 1:
        got = " and ".join(f"'{key}'" for key in keys[:5])
        raise refused(
            f"an analysis is a mapping with one key, such as 'swing_torque: ...'; {known}",
            f"got {got}: begin each analysis with its own '-'" if got else "",
        )
    if keys[0] not in ANALYSES and (near_torque(keys[0]) or not re.fullmatch(NAME, keys[0])):
        hint = did_you_mean(keys[0], ANALYSES)
        raise refused(f"unknown analysis '{keys[0][:40]}'; {known}", hint)
    return keys[0]


def near_torque(name: str) -> bool:
    """Say whether a name is nearly that of an analysis of torque."""
    return bool(difflib.get_close_matches(name, ANALYSES, n=1, cutoff=0.8))


@cache
def _reader(name: str) -> SchemaValidator:
    """Return what reads an analysis with its key, so that a mistake has the place with the key."""
    held = core_schema.typed_dict_field(_schema(ANALYSES[name]))
    return SchemaValidator(core_schema.typed_dict_schema({name: held}))


def _schema(model: type[TorqueAnalysis]) -> core_schema.CoreSchema:
    model.model_rebuild()
    return model.__pydantic_core_schema__
