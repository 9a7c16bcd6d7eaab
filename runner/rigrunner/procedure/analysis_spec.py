"""What a procedure asks of the analysis."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, ValidationError, model_validator
from pydantic_core import InitErrorDetails

from rigrunner.api.measurand import Condition, MeasurandKind
from rigrunner.api.settings import Angle, Duration, ListOf, Settings
from rigrunner.yamlfile.names import Identifier, Name, Text

LATEST = "latest"
THIS_RUN = "this run"
LABEL = "as"
"""The key that names one use of a plugin, so that it can be used twice."""
_DAY_S = 86400.0
_DEGREE = 0.017453292519943295


class PluginRef(Settings):
    """A plugin by its name, with settings or without: `grubbs` or `{grubbs: {alpha: 0.05}}`."""

    kind: ClassVar[str]
    """The kind of plugin that is named, as the registry has it."""
    name: Text
    settings: dict[str, Any] = Field(default_factory=dict)
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
            raise _at(cls, names[0], settings)
        return {"name": names[0], "settings": settings or {}, LABEL: value.get(LABEL, names[0])}


def _at(model: type[PluginRef], name: str, settings: object) -> ValidationError:
    """Return the refusal of settings that are no mapping, placed where they stand."""
    details = InitErrorDetails(type="dict_type", loc=(name,), input=settings)
    return ValidationError.from_exception_data(model.__name__, [details])


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
    threshold: Annotated[float, Field(ge=1.0, le=1000.0)] = 6.0
    """How many robust sigmas from the median of the window a sample may be."""


class Despike(Settings):
    """How spikes of single samples are removed."""

    hampel: Hampel
    """Hampel's filter: a running median, and the spread around it."""

    @property
    def window(self) -> int:
        """How many samples a spike is compared with."""
        return self.hampel.window

    @property
    def threshold(self) -> float:
        """How many robust sigmas a sample may differ."""
        return self.hampel.threshold


class NoLoadSpec(Settings):
    """Which run the rig's own part comes from, and what it must have in common with this one."""

    from_: Annotated[str, Field(alias="from", min_length=1)] = LATEST
    """'latest', or a run by its folder or name, or 'this run': its set-points without load."""
    procedure: Identifier | None = None
    """The id of the procedure that it must be a run of; needless with 'this run'."""
    max_age: Annotated[Duration, Field(gt=0)] = 30 * _DAY_S
    """How long ago it may have started."""
    same: ListOf[Literal["station", "mandrel"]] = ("station", "mandrel")
    """What both runs must have in common."""

    @model_validator(mode="after")
    def _names_a_procedure(self) -> Self:
        if self.procedure is None and not self.is_this_run:
            raise ValueError(f"the key 'procedure' is missing, or 'from: {THIS_RUN}'")
        return self

    @property
    def is_this_run(self) -> bool:
        """Whether the run itself has the set-points without load."""
        return self.from_ == THIS_RUN


class StartsSpec(Settings):
    """Every recording is a start from rest, and its first travel is looked at."""

    window: Annotated[Angle, Field(gt=0)] = 5 * _DEGREE
    """The first travel, in which the greatest torque is looked for."""
    smoothing: Annotated[Duration, Field(gt=0, le=0.1)] = 0.005
    """Of the running mean whose greatest value counts: noise would make a single sample high."""


class AnalysisSpec(Settings):
    """The analysis section; a procedure without one records and computes nothing."""

    no_load: NoLoadSpec | None = None
    starts: StartsSpec | None = None
    """The recordings are starts from rest in place of swings; `{}` for the defaults."""
    despike: Despike | None = None
    outliers: OutlierRuleRef | None = None
    fits: ListOf[FitRef] = ()
    """Of the no-load peaks over frequency; the first serves compensations that need one."""
    compensations: ListOf[CompensationRef] = ()
    """Done side by side, on the same raw data."""
    primary_: Annotated[
        Name | None,
        Field(alias="primary", json_schema_extra={"x-plugin": "compensation", "x-labelled": True}),
    ] = None
    """The compensation that the headline and the verdict use; needless where there is but one."""

    @property
    def primary(self) -> str:
        """The label of the compensation that the headline and the verdict use; '' for none."""
        only = self.compensations[0].label if len(self.compensations) == 1 else ""
        return self.primary_ or only

    @property
    def primary_plugin(self) -> CompensationRef | None:
        """The compensation that the headline and the verdict use."""
        return next((each for each in self.compensations if each.label == self.primary), None)

    def measured(self, yielded: MeasurandKind) -> MeasurandKind:
        """Return which torque a compensation that yields this gives of what is recorded here.

        Of starts from rest no method gives the torque at a reversal.
        """
        condition = yielded.condition if self.starts is None else Condition.FROM_REST
        return MeasurandKind(yielded.nature, condition)
