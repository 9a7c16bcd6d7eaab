"""The result of an analysis: what the report shows and `result.json` carries."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from math import nan
from typing import TYPE_CHECKING, TypeVar
from warnings import warn

from rigrunner.api.details import AnalysisDetails
from rigrunner.api.events import CONCLUDED
from rigrunner.api.readings import reading_text
from rigrunner.api.verdict import worst

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.api.analysis import Check, Compensation
    from rigrunner.api.data import Estimate, Measurement, RunData
    from rigrunner.api.figures import Figure
    from rigrunner.api.findings import Formula, MeasurementResult, ReportSection, Table
    from rigrunner.api.verdict import Decision, LaterDecision, LimitDecision, Verdict

_Details = TypeVar("_Details", bound=AnalysisDetails)
REPLAYED = "replayed"
"""The name in a run's provenance that says from which tape it is: no instrument was asked."""


@dataclass(frozen=True)
class JudgedValue:
    """The decision on a measured value, and where in the run it stands."""

    decision: LimitDecision
    row: Measurement
    number: int
    """The row's number in its table, from 1."""

    @property
    def value(self) -> float:
        """The value as it was read, in its SI unit; nan of what is not a number."""
        return self.row.values.get(self.decision.of, nan)

    @property
    def shown(self) -> str:
        """The value in the unit of its limit, with as many digits as show on which side it is."""
        if self.decision.of in self.row.readings:
            return reading_text(self.row.readings[self.decision.of])
        return self.decision.limits.shown_apart(self.value)


@dataclass(frozen=True)
class MeasuredLimits:
    """The limits on measured values of a run, each value held against its own.

    Values are compared as they were read, without their uncertainty (simple acceptance).
    """

    values: tuple[JudgedValue, ...] = ()

    @classmethod
    def of(cls, rows: Iterable[Measurement]) -> MeasuredLimits:
        """Return the limited values of some tables."""
        return cls(tuple(_judged(rows)))

    @cached_property
    def missed(self) -> tuple[JudgedValue, ...]:
        """The values that are out of limits."""
        return tuple(each for each in self.values if not each.decision.passes)

    @property
    def verdict(self) -> Verdict | None:
        """The worst of them; None where no value has a limit."""
        return worst(each.decision.verdict for each in self.values)

    @property
    def reason(self) -> str:
        """One sentence; '' where no value has a limit."""
        if not self.values:
            return ""
        count, missed = len(self.values), len(self.missed)
        if not missed:
            return f"Measured values with limits: {count}, all within limits."
        more = f", and {missed - 1} more" if missed > 1 else ""
        first = self.missed[0].decision.reason
        return f"Measured values out of limits: {missed} of {count} ({first}{more})."


def _judged(rows: Iterable[Measurement]) -> Iterator[JudgedValue]:
    numbers = Counter[str]()
    for row in rows:
        numbers[row.name] += 1
        for decision in row.decisions:
            yield JudgedValue(decision, row, numbers[row.name])


@dataclass(frozen=True, eq=False)
class Result:
    """The outcome of the one analysis that serves online, stored and batch."""

    run: RunData
    measurand: str
    symbol: str
    results: tuple[MeasurementResult, ...] = ()
    """All results by their names, in the order of the analyses."""
    means: tuple[MeasurementResult, ...] = ()
    """The means that analyses give of their results by themselves."""
    details: tuple[AnalysisDetails, ...] = ()
    """What analyses keep besides, each of its own class; most keep nothing."""
    formulas: tuple[Formula, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[Figure, ...] = ()
    """What belongs to results besides."""
    sections: tuple[ReportSection, ...] = ()
    """Those that analyses give the report."""
    decision: Decision | None = None
    checks: tuple[Check, ...] = ()
    notes: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    """The analysis as it was asked for, resolved to defaults."""
    revisions: Mapping[str, int] = field(default_factory=dict)
    """By which revision of each method it was computed: 'analysis', 'fit linear', ..."""

    def details_of(self, kind: type[_Details]) -> _Details | None:
        """Return what an analysis keeps besides, by its class; None of one that was not made."""
        return next((each for each in self.details if isinstance(each, kind)), None)

    @property
    def headline(self) -> Estimate | None:
        """The mean that the first analysis gives of its results; None where none gives one."""
        return self.means[0].estimate if self.means else None

    @property
    def compensations(self) -> Mapping[str, Compensation]:
        """Those of `TorqueDetails`; for plugins made by 0.1.0."""
        warn(
            "ask for the torque's details: TorqueDetails.of(result).compensations",
            DeprecationWarning,
            stacklevel=2,
        )
        found = (getattr(each, "compensations", None) for each in self.details)
        return next((each for each in found if each is not None), {})

    @cached_property
    def other_results(self) -> tuple[MeasurementResult, ...]:
        """The results but those that the pages of their analysis show themselves."""
        shown = frozenset[str]().union(*(each.shown_results for each in self.details))
        return tuple(each for each in self.results if each.name not in shown)

    @property
    def every_check(self) -> tuple[Check, ...]:
        """All checks: those of the run, and of the methods whose results count."""
        return (*self.checks, *chain.from_iterable(each.method_checks for each in self.details))

    @cached_property
    def limits(self) -> MeasuredLimits:
        """The limits on measured values, each with its decision."""
        return MeasuredLimits.of(self.run.measurements)

    @property
    def verdict(self) -> Verdict | None:
        """The verdict on the run: the worst of its limits on measured values and of the decision.

        None where there is nothing to decide, and of a run that neither was completed nor stopped
        at a limit: it neither passes nor fails.
        """
        if self.run.outcome not in CONCLUDED:
            return None
        return worst((self.limits.verdict, self.decision.verdict if self.decision else None))

    @property
    def verdict_reason(self) -> str:
        """Why, in a sentence for the limits on measured values and one for the decision."""
        decided = "" if self.decision is None else self.decision.reason
        return " ".join(text for text in (self.limits.reason, decided) if text)


@dataclass(frozen=True, eq=False)
class ReportInput:
    """What a report format is given."""

    result: Result
    document: Mapping[str, object]
    """The content of `result.json`: the same numbers, with units."""
    truth: Mapping[str, Mapping[str, float]]
    """Of a simulated rig, by recording; empty on a real one."""
    provenance: Mapping[str, str]
    """Program and package versions, files and digests, as printed on the report's last page."""
    events: tuple[Mapping[str, str], ...] = ()
    """Answers, alarms and interventions, each with 'utc', 'kind' and 'text'; the kind of an
    intervention is its action, such as 'override'."""
    later_decisions: tuple[LaterDecision, ...] = ()
    """By another rule or limit than the run was made for, oldest first."""
