"""What a procedure asks of the analysis."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from rigrunner.api.settings import Duration, ListOf, Settings
from rigrunner.yamlfile.names import Identifier, Text

LATEST = "latest"
_DAY_S = 86400.0


class PluginRef(Settings):
    """A plugin by its name, with settings or without: `grubbs` or `{grubbs: {alpha: 0.05}}`."""

    kind: ClassVar[str]
    """The kind of plugin that is named, as the registry has it."""
    name: Text
    settings: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _read(cls, value: object) -> object:
        if isinstance(value, str):
            return {"name": value}
        if isinstance(value, dict) and set(value) == {"name", "settings"}:
            return value
        if not isinstance(value, dict) or len(value) != 1:
            raise ValueError("a plugin is written as 'name', or as 'name: {setting: value}'")
        name, settings = next(iter(value.items()))
        return {"name": name, "settings": {} if settings is None else settings}


class OutlierRuleRef(PluginRef):
    """A rule for gross errors: by its name, or as `name: {setting: value}`."""

    kind = "outlier_rule"


class FitRef(PluginRef):
    """A fit of torque over frequency: by its name, or as `name: {setting: value}`."""

    kind = "fit"


class CompensationRef(PluginRef):
    """A way to take out the rig's part: by its name, or as `name: {setting: value}`."""

    kind = "compensation"


class Hampel(Settings):
    """Samples that stand out of the window around them are replaced by its median."""

    window: Annotated[int, Field(ge=3, le=1001)] = 11
    """How many samples, the one in question in their middle."""


class Despike(Settings):
    """How spikes of single samples are removed."""

    hampel: Hampel
    """Hampel's filter: a running median, and the spread around it."""

    @property
    def window(self) -> int:
        """How many samples a spike is compared with."""
        return self.hampel.window


class NoLoadSpec(Settings):
    """Which run the rig's own part comes from, and what it must have in common with this one."""

    from_: Annotated[str, Field(alias="from", min_length=1)] = LATEST
    """'latest', or a run by its folder or name."""
    procedure: Identifier
    """The id of the procedure that it must be a run of."""
    max_age: Annotated[Duration, Field(gt=0)] = 30 * _DAY_S
    """How long ago it may have started."""
    same: ListOf[Literal["station", "mandrel"]] = ("station", "mandrel")
    """What both runs must have in common."""


class AnalysisSpec(Settings):
    """The analysis section; a procedure without one records and computes nothing."""

    no_load: NoLoadSpec | None = None
    despike: Despike | None = None
    outliers: OutlierRuleRef | None = None
    fits: ListOf[FitRef] = ()
    """Of the no-load peaks over frequency; the first serves compensations that need one."""
    compensations: ListOf[CompensationRef] = ()
    """Done side by side, on the same raw data."""
    primary: Annotated[str, Field(json_schema_extra={"x-plugin": "compensation"})] = ""
    """The compensation that the headline and the verdict use."""
