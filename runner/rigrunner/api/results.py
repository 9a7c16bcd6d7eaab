"""Results of a run, as shown by the report and written to `result.json`."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from math import nan
from typing import TYPE_CHECKING, Any, TypeVar

from rigrunner.api.details import AnalysisDetails
from rigrunner.api.events import CONCLUDED
from rigrunner.api.limits import ValueLimit
from rigrunner.api.readings import reading_text
from rigrunner.api.verdict import Verdict, worst
from rigrunner.moved import moved

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.analysis import Check
    from rigrunner.api.data import Estimate, Measurement, RunData
    from rigrunner.api.figures import Figure
    from rigrunner.api.findings import (
        Formula,
        MeasurementResult,
        MissingResult,
        ReportSection,
        Table,
    )
    from rigrunner.api.readings import ReadingLimit
    from rigrunner.api.verdict import Decision, LaterDecision, LimitDecision

_Details = TypeVar("_Details", bound=AnalysisDetails)
REPLAYED = "replayed"
"""Key in the provenance of a run: the tape that it replayed, without instruments."""


@dataclass(frozen=True, slots=True)
class JudgedValue:
    """A measured value or reading that has a limit, and its place in the run."""

    limit: ValueLimit | ReadingLimit
    row: Measurement
    number: int
    """Number of the row in its table, from 1."""

    @property
    def decision(self) -> LimitDecision:
        """The decision on it, made each time: of many values most are only counted."""
        if isinstance(self.limit, ValueLimit):
            return self.limit.decision(self.row.values[self.limit.of])
        return self.limit.decision(self.row.readings[self.limit.of])

    @property
    def passes(self) -> bool:
        """Whether the decision is `pass`."""
        if isinstance(self.limit, ValueLimit):
            return self.limit.limits.allow(self.row.values[self.limit.of])
        return self.row.readings[self.limit.of] in self.limit.allowed

    @property
    def value(self) -> float:
        """The value as read, in its SI unit; nan for a reading that is not a number."""
        return self.row.values.get(self.limit.of, nan)

    @property
    def shown(self) -> str:
        """The value in the unit of its limit, with enough digits to show its side of the limit."""
        if isinstance(self.limit, ValueLimit):
            return self.limit.limits.shown_apart(self.value)
        return reading_text(self.row.readings[self.limit.of])


@dataclass(frozen=True)
class MeasuredLimits:
    """Limits of measured values of a run, with a decision on each value.

    Values are compared as read, without their uncertainty (simple acceptance).
    """

    values: tuple[JudgedValue, ...] = ()

    @classmethod
    def of(cls, rows: Iterable[Measurement]) -> MeasuredLimits:
        """Return the limited values of tables."""
        numbers = Counter[str]()
        values = []
        for row in rows:
            numbers[row.name] += 1
            limits: tuple[ValueLimit | ReadingLimit, ...] = (
                *(limit for limit in row.limits if limit.of in row.values),
                *(limit for limit in row.expected if limit.of in row.readings),
            )
            values += [JudgedValue(limit, row, numbers[row.name]) for limit in limits]
        return cls(tuple(values))

    @cached_property
    def missed(self) -> tuple[JudgedValue, ...]:
        """The values out of limits."""
        return tuple(value for value in self.values if not value.passes)

    @property
    def verdict(self) -> Verdict | None:
        """The worst verdict; None without limits."""
        if not self.values:
            return None
        return Verdict.FAIL if self.missed else Verdict.PASS

    @property
    def reason(self) -> str:
        """One sentence; '' without limits."""
        if not self.values:
            return ""
        count, missed = len(self.values), len(self.missed)
        if not missed:
            return f"Measured values with limits: {count}, all within limits."
        more = f", and {missed - 1} more" if missed > 1 else ""
        first = self.missed[0].decision.reason
        return f"Measured values out of limits: {missed} of {count} ({first}{more})."


@dataclass(frozen=True, eq=False)
class Result:
    """The results of a run; online, stored and batch analyses give the same."""

    run: RunData
    measurand: str
    symbol: str
    unit: str = ""
    """Of the measurand; '' if not stated."""
    results: tuple[MeasurementResult, ...] = ()
    """All results by name, in the order of the analyses."""
    missing: tuple[MissingResult, ...] = ()
    """Places at which a result has no value."""
    means: tuple[MeasurementResult, ...] = ()
    """Means that analyses calculate themselves."""
    details: tuple[AnalysisDetails, ...] = ()
    """Further records of analyses, each of its own class; most have none."""
    formulas: tuple[Formula, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    """Figures for results."""
    sections: tuple[ReportSection, ...] = ()
    """Report sections of analyses."""
    decision: Decision | None = None
    checks: tuple[Check, ...] = ()
    notes: tuple[str, ...] = ()
    beyond: Mapping[str, str] = field(default_factory=dict)
    """By channel, how far readings exceed the calibrated range of its instrument; each is a note
    too."""
    settings: Mapping[str, object] = field(default_factory=dict)
    """The settings of the analyses, with defaults."""
    revisions: Mapping[str, int] = field(default_factory=dict)
    """The revision of each method: 'analysis', 'fit linear', ..."""

    def details_of(self, kind: type[_Details]) -> _Details | None:
        """Return the details of an analysis by class; None if there are none."""
        return next((details for details in self.details if isinstance(details, kind)), None)

    @property
    def headline(self) -> Estimate | None:
        """The mean of the first analysis that states one; None for none."""
        return self.means[0].estimate if self.means else None

    if not TYPE_CHECKING:  # a checker would take any name

        def __getattr__(self, name: str) -> Any:
            """Return a name that has moved from this class; raise AttributeError for any other."""
            return moved(f"{__name__}.Result", name)(self)

    @cached_property
    def other_results(self) -> tuple[MeasurementResult, ...]:
        """Results except those that pages of their analysis show."""
        shown = frozenset[str]().union(*(details.shown_results for details in self.details))
        return tuple(result for result in self.results if result.name not in shown)

    @property
    def every_check(self) -> tuple[Check, ...]:
        """All checks: those of the run, and of the methods whose results count."""
        return (*self.checks, *chain.from_iterable(each.method_checks for each in self.details))

    @cached_property
    def limits(self) -> MeasuredLimits:
        """The limits of measured values, each with its decision."""
        return MeasuredLimits.of(self.run.measurements)

    @property
    def verdict(self) -> Verdict | None:
        """The verdict on the run: the worst of measured values and of the decision.

        None without a decision, and for a run that was neither completed nor stopped at a limit.
        """
        if self.run.outcome not in CONCLUDED:
            return None
        return worst((self.limits.verdict, self.decision.verdict if self.decision else None))

    @property
    def verdict_reason(self) -> str:
        """One sentence on the limits of measured values and one on the decision."""
        reason = "" if self.decision is None else self.decision.reason
        return " ".join(text for text in (self.limits.reason, reason) if text)


@dataclass(frozen=True, eq=False)
class ReportInput:
    """The input of a report format."""

    result: Result
    document: Mapping[str, object]
    """The content of `result.json`: the same numbers, with units."""
    truth: Mapping[str, Mapping[str, float]]
    """Truth of a simulated rig by recording; empty for a real one."""
    provenance: Mapping[str, str]
    """Versions of program and packages, files and digests, for the last page of the report."""
    events: tuple[Mapping[str, str], ...] = ()
    """Answers, alarms and interventions, each with 'utc', 'kind' and 'text'; the kind of an
    intervention is its action, such as 'override'."""
    later_decisions: tuple[LaterDecision, ...] = ()
    """Later decisions by another rule or limit, oldest first."""
