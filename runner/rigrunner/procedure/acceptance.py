"""What is acceptable: limits, each of one measurand, and the rule by which they are applied."""

from __future__ import annotations

from collections import Counter
from math import isclose
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from rigrunner.api.measurand import CONDITIONS, NATURES, Condition, MeasurandKind, Nature
from rigrunner.api.settings import Force, Frequency, ListOf, Settings, Torque
from rigrunner.procedure.analysis_spec import PluginRef
from rigrunner.procedure.result_limits import ResultLimit
from rigrunner.yamlfile.names import Text

if TYPE_CHECKING:
    from collections.abc import Iterable

LOAD_TOLERANCE = 0.01
"""How far a load may be from that of the limit, as a part of it."""
UNLOADED_N = 10.0
"""What a load cell may show of a bearing without load."""
FREQUENCY_TOLERANCE = 1e-6


class LimitMeasurand(Settings):
    """Which torque a limit is for; it says nothing of any other."""

    nature: Literal["load_induced", "total", "no_load"]
    """What the load adds, all under load, or all without load."""
    condition: Literal["at_reversal", "from_rest", "under_way"]
    """At the reversals of a swing, at the first movement after a rest, or as a mean on the way."""
    load: Force | None = None
    """The load at which it holds; left out, at any."""

    @property
    def kind(self) -> MeasurandKind:
        """Nature and condition."""
        return MeasurandKind(Nature(self.nature), Condition(self.condition))

    def __str__(self) -> str:
        """Return it in words: 'load-induced torque at the reversals of a swing under 1000 N'."""
        return str(self.kind) if self.load is None else f"{self.kind} under {self.load:g} N"

    def objection(self, found: MeasurandKind, loads_n: Iterable[float]) -> str:
        """Return why this is not the torque that was found under those loads; '' if it is."""
        loads = sorted(loads_n)
        unloaded = bool(loads) and loads[-1] <= UNLOADED_N
        natures = {found.nature}
        if found.nature is Nature.TOTAL and (unloaded or not loads):
            natures.add(Nature.NO_LOAD)
        fits = self.kind.nature in natures and self.kind.condition is found.condition
        if fits and (self.load is None or all(self._is_at(load) for load in loads)):
            return ""
        return f"the limit is for the {self}, and the result is the {_words(found, loads)}"

    def _is_at(self, load_n: float) -> bool:
        assert self.load is not None  # noqa: S101  (asked only where there is one)
        return abs(load_n - self.load) <= (LOAD_TOLERANCE * self.load or UNLOADED_N)


class Limit(Settings):
    """What a torque may be, in N·m, which torque, and who says so."""

    max: Torque | None = None
    """The highest that is allowed."""
    min: Torque | None = None
    """The lowest that is allowed."""
    of: Literal["mean", "each_frequency"] = "mean"
    """What must be within it: the mean over all set-points, or each set-point's own torque."""
    at: ListOf[Annotated[Frequency, Field(gt=0)]] = ()
    """Only these set frequencies, with `of: each_frequency`; left out, all with no other limit."""
    source: Text
    """Who says so: a standard with its edition, a drawing, an agreement."""
    measurand: LimitMeasurand
    """Which torque it is a limit of: it is refused for any other."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.max is None and self.min is None:
            raise ValueError("a limit needs max, min, or both")
        if self.max is not None and self.min is not None and self.min >= self.max:
            raise ValueError(f"min ({self.min:g} N·m) must be below max ({self.max:g} N·m)")
        if self.at and self.of == "mean":
            raise ValueError("frequencies under 'at' need 'of: each_frequency'")
        return self

    def names(self, frequency_hz: float) -> bool:
        """Return whether it is a limit for that set frequency by name."""
        return any(_same(frequency_hz, each) for each in self.at)

    def missing(self, frequencies_hz: Iterable[float]) -> list[float]:
        """Return the named frequencies that are not among those that were set."""
        there = tuple(frequencies_hz)
        return [each for each in self.at if not any(_same(each, hz) for hz in there)]

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it, with units; read back, it is the same."""
        load = self.measurand.load
        return {
            **_given(max=_torque(self.max), min=_torque(self.min)),
            **({} if self.of == "mean" else {"of": self.of}),
            **_given(at=[f"{hz!r} Hz" for hz in self.at] or None),
            "source": self.source,
            "measurand": {
                "nature": self.measurand.nature,
                "condition": self.measurand.condition,
                **_given(load=None if load is None else f"{load!r} N"),
            },
        }


_OF_TORQUE = ("mean", "each_frequency")


def _kind(value: object) -> str:
    of = value.get("of", "mean") if isinstance(value, dict) else getattr(value, "of", "")
    return "torque" if of in _OF_TORQUE else "result"


AnyLimit = Annotated[
    Annotated[Limit, Tag("torque")] | Annotated[ResultLimit, Tag("result")], Discriminator(_kind)
]
"""A limit of the compensated torque, or of a result by its name."""


class DecisionRuleRef(PluginRef):
    """A decision rule: by its name, or as `name: {setting: value}`."""

    kind = "decision_rule"

    def as_written(self) -> str | dict[str, object]:
        """Return it as a file has it; read back, it is the same."""
        return {self.name: dict(self.settings)} if self.settings else self.name


class Acceptance(Settings):
    """The limits and the rule by which they are decided; agreed before anything is measured."""

    limit: Limit | None = None
    """The limit, where there is one alone."""
    limits: ListOf[AnyLimit] = ()
    """Several: of results by their names; of the compensated torque one of the mean, one of each
    frequency, others for named frequencies."""
    rule: Annotated[DecisionRuleRef, Field(validate_default=True)] = "simple"  # type: ignore[assignment]  # validated
    """How far within its limit a result must be, and whether there is more than pass and fail."""
    fraction: Annotated[float, Field(gt=0, le=5)] | None = None
    """The same as the setting `fraction` of the rule, such as of `guard_band_fraction`."""
    marginal: Annotated[Torque, Field(gt=0)] | None = None
    """A verdict that so small a difference would change is called marginal."""

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.limit is None) == (not self.limits):
            raise ValueError("one of 'limit' and 'limits' is needed, not both")
        if self.fraction is not None and self.rule.settings:
            raise ValueError("'fraction' belongs to the other settings of the rule")
        twice = [name for name, count in Counter(self._scopes()).items() if count > 1]
        if twice:
            raise ValueError(f"there are two limits of {twice[0]}")
        return self

    @property
    def rule_settings(self) -> dict[str, Any]:
        """The settings of the rule."""
        return {**self.rule.settings, **_given(fraction=self.fraction)}

    @property
    def torque_limits(self) -> tuple[Limit, ...]:
        """The limits of the compensated torque."""
        given = self.limits if self.limit is None else (self.limit,)
        return tuple(each for each in given if isinstance(each, Limit))

    @property
    def result_limits(self) -> tuple[ResultLimit, ...]:
        """The limits of results by their names."""
        return tuple(each for each in self.limits if isinstance(each, ResultLimit))

    @property
    def mean_limit(self) -> Limit | None:
        """The limit of the mean over all set-points, if there is one."""
        return next((each for each in self.torque_limits if each.of == "mean"), None)

    def limit_at(self, frequency_hz: float) -> Limit | None:
        """Return the limit of one set-point: the one that names it, or else the one of each."""
        own = [each for each in self.torque_limits if each.of == "each_frequency"]
        named = (each for each in own if each.names(frequency_hz))
        return next(named, next((each for each in own if not each.at), None))

    def as_written(self) -> dict[str, object]:
        """Return it as a file has it, with units; read back, it is the same."""
        several = [each.as_written() for each in self.limits]
        return {
            **_given(limit=None if self.limit is None else self.limit.as_written()),
            **_given(limits=several or None),
            "rule": self.rule.as_written(),
            **_given(fraction=self.fraction, marginal=_torque(self.marginal)),
        }

    def _scopes(self) -> list[str]:
        """Return what each limit is of, in words that are equal for equal scopes."""
        return [
            scope
            for each in self.torque_limits
            for scope in ([f"{hz:g} Hz" for hz in each.at] or [each.of.replace("_", " ")])
        ] + [each.scope for each in self.result_limits]


class AcceptanceFile(Settings):
    """A file with limits and rule alone, to decide a stored run again."""

    rigrunner: Literal["acceptance/1"]
    """What this file is, and its version of the language."""
    acceptance: Acceptance


def _torque(value_nm: float | None) -> str | None:
    return None if value_nm is None else f"{value_nm!r} N·m"


def _given(**values: object) -> dict[str, object]:
    return {name: value for name, value in values.items() if value is not None}


def _same(one_hz: float, other_hz: float) -> bool:
    return isclose(one_hz, other_hz, rel_tol=FREQUENCY_TOLERANCE)


def _words(found: MeasurandKind, loads_n: list[float]) -> str:
    nature, condition = NATURES[found.nature], CONDITIONS[found.condition]
    if not loads_n:
        return f"{nature} {condition}"
    low, high = loads_n[0], loads_n[-1]
    span = f"{low:.0f} N" if high - low <= LOAD_TOLERANCE * high else f"{low:.0f} N to {high:.0f} N"
    return f"{nature} {condition} under {span}"
