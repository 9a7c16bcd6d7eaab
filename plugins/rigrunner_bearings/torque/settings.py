"""Settings of the analyses of torque in procedures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api import Angle, Duration, ListOf, PartnerRun, ResultDefinition, Settings
from rigrunner.api.analysis.requirements import LATEST, STATION
from rigrunner.api.labels import Labels
from rigrunner.api.names import Identifier, Name, Text
from rigrunner.api.plugin_refs import FitRef, OutlierRuleRef, PluginRef
from rigrunner_bearings.api.measurand import Condition, MeasurandKind

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    from rigrunner.api import NeededRun

NO_LOAD = "no_load"
NO_LOAD_AFTER = "no_load_after"
"""The names of the torque's partner runs."""
THIS_RUN = "this run"
MONTE_CARLO = "monte_carlo"
BY_TIME = "time"
FREQUENCY = "frequency"
"""The coordinate of a torque: the set frequency of the swing or of the turning."""
_HOUR_S = 3600.0
_DEGREE = 0.017453292519943295


class CompensationRef(PluginRef):
    """A way to subtract the rig's no-load torque: by its name, or as `name: {setting: value}`."""

    kind = "compensation"


class Hampel(Settings):
    """Outliers in a moving window are replaced by its median."""

    window: Annotated[int, Field(ge=3, le=1001)] = 11
    """Length of the window in samples, centred on the tested one."""
    threshold: Annotated[float, Field(ge=1.0, le=1000.0)] = 6.0
    """Largest distance from the median, in robust standard deviations."""


class Despike(Settings):
    """Removal of spikes in single samples."""

    hampel: Hampel
    """Hampel filter: moving median, and the spread around it."""

    @property
    def window(self) -> int:
        """How many samples a spike is compared with."""
        return self.hampel.window

    @property
    def threshold(self) -> float:
        """How many robust sigmas a sample may differ."""
        return self.hampel.threshold


class NoLoadSpec(PartnerRun):
    """Selects the run with the rig's no-load torque, and what both runs must have in common."""

    from_: Annotated[str, Field(alias="from", min_length=1)] = LATEST
    """'latest', or a run by its folder or name, or 'this run': its set-points without load."""
    procedure: Identifier | None = None
    """The id of its procedure; not needed with 'this run'."""
    max_age: Annotated[Duration, Field(gt=0)] = 8 * _HOUR_S
    """Longest time since its start: a support warms up, and its friction changes."""
    same: ListOf[Text] = (STATION, "mandrel")
    """What both runs must have in common: 'station', and keys of the rig."""

    after: bool = False
    """Whether a second no-load run follows; the run is kept open until `resume` uses it."""

    drift: Annotated[str, Field(min_length=1)] = BY_TIME
    """With `after`, or with 'this run' and no-load set-points before and after the loaded ones: the
    quantity over which the rig's torque changes linearly in between, 'time' or a channel such as
    'tester.temperature'."""

    @model_validator(mode="after")
    def _names_a_procedure(self) -> Self:
        if self.procedure is None and not self.is_this_run:
            raise ValueError(f"the key 'procedure' is missing, or 'from: {THIS_RUN}'")
        if self.after and self.is_this_run:
            raise ValueError(f"'after' is for a run of its own, not for 'from: {THIS_RUN}'")
        if self.drift != BY_TIME and not (self.is_this_run or self.after):
            needed = f"'after: true' or 'from: {THIS_RUN}'"
            raise ValueError(f"'drift' needs {needed}: no-load points before and after")
        return self

    @property
    def is_this_run(self) -> bool:
        """Whether the run itself has the set-points without load."""
        return self.from_ == THIS_RUN

    def partners(self) -> tuple[NeededRun, ...]:
        """Return the runs that it asks for: before the run, and after it where both are wanted."""
        if self.is_this_run:
            return ()
        before = self.needed(NO_LOAD, ("no_load",))
        after = self.needed(NO_LOAD_AFTER, ("no_load",), after=True)
        return (before, after) if self.after else (before,)


class StartsSpec(Settings):
    """Every recording is a start from rest, whose first travel is evaluated."""

    window: Annotated[Angle, Field(gt=0)] = 5 * _DEGREE
    """Travel from the start in which the greatest torque is searched."""
    smoothing: Annotated[Duration, Field(gt=0, le=0.1)] = 0.005
    """Length of the moving average whose greatest value counts; it suppresses noise."""


class MonteCarloSpec(Settings):
    """Checks the primary method's uncertainty by random trials (JCGM 101:2008)."""

    trials: Annotated[int, Field(ge=1_000_000, le=100_000_000)] = 1_000_000
    """Minimum number of trials of the measurement equation, for each set-point and the mean."""
    most_trials: Annotated[int, Field(ge=1_000_000, le=100_000_000)] = 10_000_000
    """Maximum number of trials if the results have not stabilised; at least `trials`."""
    draws: Annotated[int, Field(ge=500, le=100_000)] = 500
    """Number of draws of the recorded data, each analysed again."""
    digits: Annotated[int, Field(ge=1, le=2)] = 1
    """Significant digits of u: both must agree to half the last one."""
    seed: Annotated[int, Field(ge=0)] = 1
    """Seed of the random numbers: the same seed gives the same result."""


class ValidateSpec(Settings):
    """Validation of the result by another method: `monte_carlo`, with or without settings."""

    monte_carlo: MonteCarloSpec
    """Random trials of the measurement equation, and draws of the recorded data."""

    @model_validator(mode="before")
    @classmethod
    def _read(cls, value: object) -> object:
        if value in (MONTE_CARLO, {MONTE_CARLO: None}):
            return {MONTE_CARLO: {}}
        if isinstance(value, str):
            # pydantic places a ValueError, not a TypeError, where the value stands
            raise ValueError(f"got '{value}', but a result is validated by '{MONTE_CARLO}'")  # noqa: TRY004  (see above)
        return value

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of what is written: the name alone, or a mapping."""
        schema: JsonSchemaValue = handler(core_schema)
        return {"anyOf": [{"const": MONTE_CARLO, "type": "string"}, schema]}


class TorqueSettings(Settings):
    """Settings of an analysis of torque: its plugins, and the primary compensation."""

    name: Name = "torque"
    """Name of the compensated torque in limits and documents."""
    where: Labels = Field(
        default_factory=dict,
        description="Only recordings and rows with these counters and labels; if omitted, all.",
    )
    no_load: NoLoadSpec | None = None
    """The run with the rig's no-load torque."""
    despike: Despike | None = None
    """Removal of spikes in single samples; if omitted, they stay."""
    outliers: OutlierRuleRef | None = None
    """The rule for gross errors; if omitted, no value is rejected."""
    fits: ListOf[FitRef] = ()
    """Fits of the no-load peaks over frequency; compensations that need one use the first."""
    compensations: ListOf[CompensationRef] = ()
    """Compensations, side by side on the same raw data."""
    primary_: Annotated[
        Name | None,
        Field(alias="primary", json_schema_extra={"x-plugin": "compensation", "x-labelled": True}),
    ] = None
    """The compensation for headline and verdict; not needed if there is only one."""

    validate_: Annotated[ValidateSpec | None, Field(alias="validate")] = None
    """Whether the primary method's uncertainty is checked by Monte Carlo; it takes minutes."""

    @property
    def starts(self) -> StartsSpec | None:
        """How starts from rest are evaluated; None if the recordings are of swings."""
        return None

    @property
    def has_own_no_load(self) -> bool:
        """Whether the run itself has the set-points without load."""
        return self.no_load is not None and self.no_load.is_this_run

    @property
    def primary(self) -> str:
        """The label of the compensation that the headline and the verdict use; '' for none."""
        only = self.compensations[0].label if len(self.compensations) == 1 else ""
        return self.primary_ or only

    @property
    def primary_plugin(self) -> CompensationRef | None:
        """The compensation that the headline and the verdict use."""
        return next(
            (reference for reference in self.compensations if reference.label == self.primary), None
        )

    def yields(self, symbol: str, text: str, kind: MeasurandKind | None) -> ResultDefinition | None:
        """Return the definition of the compensated torque; None where nothing is compensated."""
        if not self.compensations:
            return None
        return ResultDefinition(
            name=self.name, symbol=symbol, text=text, unit="N·m", per=(FREQUENCY,), measurand=kind
        )

    def measured(self, yielded: MeasurandKind) -> MeasurandKind:
        """Return which torque a compensation that yields this gives of what is recorded here.

        Of starts from rest no method gives the torque at a reversal.
        """
        condition = yielded.condition if self.starts is None else Condition.FROM_REST
        return MeasurandKind(yielded.nature, condition)


class SwingTorque(TorqueSettings):
    """Torque at the reversals of swings, from recordings or from measured values."""


class Breakaway(TorqueSettings, StartsSpec):
    """Torque at the first movement: every recording is a start from rest."""

    @property
    def starts(self) -> StartsSpec:
        """How its starts are evaluated."""
        return self
