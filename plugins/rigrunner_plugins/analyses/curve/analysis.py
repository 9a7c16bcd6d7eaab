"""The analysis `curve`: fits values over x and derives results, each with its uncertainty budget.

Type A is the scatter about the curve (GUM H.3). Type B comes from the register entries of the
instruments of y and x, or from the budgets of the results that are y and x: the points are fitted
again with an error applied to all of them, so a gain or an offset acts on each result as it acts on
the curve. An error stated as one figure may differ between readings, so its greatest possible
effect counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import inf, isfinite, isnan, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import (
    Component,
    DataError,
    Estimate,
    Findings,
    MeasurementResult,
    find_unit,
    unit,
)
from rigrunner.api.findings import MissingResult
from rigrunner.signal.coverage import excess_kurtosis
from rigrunner.signal.uncertainty import combine
from rigrunner_plugins.analyses.curve import derived
from rigrunner_plugins.analyses.curve.derived import Derived, Fitted, OutOfRangeError
from rigrunner_plugins.analyses.curve.figure import figures_of
from rigrunner_plugins.analyses.curve.formula import mathematics
from rigrunner_plugins.analyses.curve.of_results import sources_of_results
from rigrunner_plugins.analyses.curve.points import STEP, Which, sources
from rigrunner_plugins.analyses.curve.settings import (
    BothWays,
    Nonlinearity,
    Slope,
    ValueAt,
    XAt,
    ZeroReturn,
)
from rigrunner_plugins.analyses.settings import unit_of_errors

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Fit, ResultDefinition, RunData
    from rigrunner.api.accuracy import ReadingError
    from rigrunner.api.figures import Figure
    from rigrunner_plugins.analyses.curve.points import Source, Values
    from rigrunner_plugins.analyses.curve.settings import CurveSettings
    from rigrunner_plugins.analyses.curve.shared_lines import SharedLine
    from rigrunner_plugins.analyses.settings import ResultSettings

ROUNDING = 1e-12
"""Change of a value, relative to it, that is no effect; `STEP` of a gain gives some 1e-6."""
SCATTER = "scatter about the curve"
_Errors = dict[str, DataError | OutOfRangeError]
"""Why results have no value, by their names."""


@dataclass(frozen=True)
class CurveAnalysis:
    """Implements `rigrunner.api.findings.Analysis`."""

    settings: CurveSettings
    fit: Fit

    def __call__(
        self,
        run: RunData,
        others: Sequence[MeasurementResult] = (),
        lacking: Sequence[MissingResult] = (),
    ) -> Findings:
        """Return the results of the curves, and those without a value at a place, with the reason.

        `others` are results of other analyses, `lacking` those without a value at a place.

        Raises DataError for a result that the data of no place give.
        """
        results: list[MeasurementResult] = []
        missing: list[MissingResult] = []
        refused: dict[str, DataError] = {}
        notes: dict[str, None] = {}
        figures: list[Figure] = []
        curves: list[tuple[str, Fitted]] = []
        found_sources = (
            sources_of_results(run, self.settings, (*others, *lacking))
            if self.settings.is_of_results
            else sources(run, self.settings)
        )
        for source in found_sources:
            one = _OneCurve(self.settings, self.fit, source)
            found, errors = one.results(notes)
            results += found
            missing += [
                MissingResult(of=of, coordinates=source.place, why=str(errors[of.name]).rstrip("."))
                for of in self.settings.yields()
                if of.name in errors
            ]
            refused |= {name: e for name, e in errors.items() if isinstance(e, DataError)}
            if found:
                curves.append((found[0].place, one.fitted))
                if len(self.settings.over) == 1:
                    figures.extend(one.figures(found[0].name))
        for name in refused.keys() - {each.name for each in results}:
            raise refused[name]
        order = {each.name: index for index, each in enumerate(self.settings.yields())}
        results.sort(key=lambda each: order[each.name])
        missing.sort(key=lambda each: order[each.name])
        formulas, tables = (
            mathematics(curves, self.settings, results[0].name) if results else ((), ())
        )
        return Findings(
            results=tuple(results),
            missing=tuple(missing),
            notes=tuple(notes),
            figures=tuple(figures),
            formulas=formulas,
            tables=tables,
        )


@dataclass(frozen=True)
class _OneCurve:
    settings: CurveSettings
    fit: Fit
    source: Source

    def results(self, notes: dict[str, None]) -> tuple[list[MeasurementResult], _Errors]:
        """Return the results, and by name why others have no value; add to the notes."""
        errors: _Errors = {}
        try:
            return list(self._results(self.fitted, errors, notes)), errors
        except DataError as error:  # the fit failed: there is no result
            return [], {each.name: error for each in self.settings.yields()} | errors

    def _results(
        self, fitted: Fitted, errors: _Errors, notes: dict[str, None]
    ) -> Iterator[MeasurementResult]:
        found: list[tuple[ResultDefinition, ResultSettings, Derived]] = []
        for definition, (_, wanted) in zip(
            self.settings.yields(), self.settings.results.all_of(), strict=True
        ):
            try:
                derived_value = self._derived(fitted, wanted)
            except (OutOfRangeError, DataError) as error:
                errors[definition.name] = error
                continue
            found.append((definition, wanted, derived_value))
            if derived_value.note:
                notes[f"{definition.name}{self._place}: {derived_value.note}."] = None
        notes.update(dict.fromkeys(self._correlations(fitted)))
        for place in self.source.left_out:
            notes[
                f"{self.settings.of}: there is no point at {place}, where a value is missing."
            ] = None
        for name in self.source.exact:
            notes[f"{name} counts as exact: the register has no entry for it."] = None
        effects = self._effects(fitted, [each for _, _, each in found])
        for index, (definition, wanted, derived_value) in enumerate(found):
            of_errors = [(error, *of_each[index]) for error, of_each in effects]
            yield self._result(definition, wanted, derived_value, of_errors)

    @cached_property
    def fitted(self) -> Fitted:
        """The curve through the points as measured; raises DataError for none."""
        return self._fitted(self.source.values)

    def figures(self, of: str) -> tuple[Figure, ...]:
        """Return the figures of the curve, to be shown with a result."""
        over = next(iter(self.settings.over.values()))
        return figures_of(self.fitted, of, over, self.settings.of, self._place)

    def _correlations(self, fitted: Fitted) -> Iterator[str]:
        """Yield the correlation of each pair of parameters that are results (GUM H.3.3)."""
        named = list(self.settings.results.parameters)
        names, covariance = list(fitted.curve.names), fitted.curve.covariance
        for one, other in combinations(named, 2):
            i, k = names.index(one), names.index(other)
            r = covariance[i, k] / np.sqrt(covariance[i, i] * covariance[k, k])
            if isfinite(r):
                results = self.settings.results.parameters
                both = f"{results[one].name} and {results[other].name}"
                yield f"Correlation of {both}{self._place}: {r:.6f}."

    @property
    def _points(self) -> str:
        of, where = self.settings, self.settings.where.items()
        at = "".join(f", {name} = {value}" for name, value in (*where, *self.source.place.items()))
        return f"{SCATTER} of {of.of} over {' and '.join(of.over.values())}{at}"

    @property
    def _place(self) -> str:
        place = ", ".join(f"{name} = {each}" for name, each in self.source.place.items())
        return f" at {place}" if place else ""

    def _fitted(self, values: Values) -> Fitted:
        return Fitted(values, self.fit(values.points()))

    def _derived(self, fitted: Fitted, wanted: ResultSettings) -> Derived:
        if isinstance(wanted, ValueAt):
            return derived.value_at(fitted, wanted, self.settings.at(wanted))
        if isinstance(wanted, XAt):
            which = self.settings.results.x_at.index(wanted)
            return derived.x_at(fitted, wanted, which, self.source.counts[which])
        if isinstance(wanted, Slope):
            return derived.slope(fitted, wanted)
        if isinstance(wanted, Nonlinearity):
            return derived.nonlinearity(fitted, wanted)
        if isinstance(wanted, BothWays):
            at_zero = isinstance(wanted, ZeroReturn)
            places = self.source.places
            return derived.both_ways(fitted, wanted, places, self.fit, at_zero=at_zero)
        name = next(n for n, each in self.settings.results.parameters.items() if each is wanted)
        self._check_unit(fitted, name, wanted)
        return derived.parameter(fitted, name)

    def _check_unit(self, fitted: Fitted, name: str, wanted: ResultSettings) -> None:
        """Raise DataError if a parameter's stated unit does not match the fit's dimension."""
        units = dict(zip(fitted.curve.names, fitted.curve.units, strict=True))
        symbol = units.get(name, "")
        of_fit = find_unit(symbol)
        if of_fit is None or symbol == "1":
            return
        if unit(wanted.unit).dimension != of_fit.dimension:
            raise DataError(
                f"{wanted.name} is stated in {wanted.unit}; the parameter '{name}' of the fit is"
                f" in {symbol}"
            )

    def _effects(
        self, fitted: Fitted, found: Sequence[Derived]
    ) -> list[tuple[_Error | SharedLine, list[tuple[float, float]]]]:
        """Return each error with its greatest effect on each value, upwards and downwards."""
        columns = {self.settings.of: None} | {
            name: column
            for column, name in enumerate(self.settings.over.values())
            if name in self.source.errors
        }
        effects: list[tuple[_Error | SharedLine, list[tuple[float, float]]]] = [
            (line, self._of_line(fitted, found, line)) for line in self.source.lines
        ]
        for channel, errors in self.source.errors.items():
            column = columns[channel]
            step = STEP * float(fitted.values.ranges[0 if column is None else 1 + column])
            of_each: list[tuple[float, float]] | None = None
            for error in errors:
                if error.acts == "each":
                    if of_each is None:
                        of_each = self._of_each(fitted, found, column, step)
                    by_all = of_each
                else:
                    size = step
                    if error.acts == "gain":  # shifts the largest x by a step
                        largest = 0.0 if column is None else self._largest(column)
                        size = step / largest if largest else STEP
                    read = np.array([count > 0 for count in self.source.counts], np.float64)
                    which = Which(np.ones(len(fitted.values.y)), read)
                    by_all = self._of_one(
                        fitted, found, column, acts=error.acts, size=size, which=which
                    )
                effects.append((self._error(channel, column, error), by_all))
        for channel, error, which in self.source.of_zeros:
            column = columns.get(channel)
            step = STEP * float(fitted.values.ranges[0 if column is None else 1 + column])
            by_all = self._of_one(fitted, found, column, acts=error.acts, size=step, which=which)
            effects.append((self._error(channel, column, error), by_all))
        return effects

    def _of_one(
        self,
        fitted: Fitted,
        found: Sequence[Derived],
        column: int | None,
        *,
        acts: str,
        size: float,
        which: Which,
    ) -> list[tuple[float, float]]:
        """Return the change of each value, upwards and downwards, by an error of 1."""
        moved = self._fitted(fitted.values.with_error(column, acts, size, which))
        by = [_change(one, moved) / size for one in found]
        return [(max(each, 0.0), max(-each, 0.0)) for each in by]

    def _error(self, channel: str, column: int | None, error: ReadingError) -> _Error:
        known = self.source.values
        symbol = known.y_unit if column is None else known.units[column]
        return _Error(channel, unit_of_errors(symbol), error)

    def _largest(self, column: int) -> float:
        known = self.source.values
        return float(np.abs(known.x[:, column] + known.origin).max())

    def _of_line(
        self, fitted: Fitted, found: Sequence[Derived], line: SharedLine
    ) -> list[tuple[float, float]]:
        """Return how much each value rises and falls by one standard uncertainty of a line."""
        if not np.isfinite(line.by).all():  # of an instrument that the register does not have
            return [(nan, nan)] * len(found)
        up, down = np.zeros(len(found)), np.zeros(len(found))
        for rows in (slice(None),) if line.line.shared else fitted.values.rows():
            points, share = fitted.values.moved_by(line.by, rows)
            moved = self._fitted(points)
            change = _change if line.line.shared else _any_change
            by = np.array([change(one, moved) / share for one in found])
            up, down = up + np.maximum(by, 0.0), down + np.maximum(-by, 0.0)
        return list(zip(up.tolist(), down.tolist(), strict=True))

    def _of_each(
        self, fitted: Fitted, found: Sequence[Derived], column: int | None, step: float
    ) -> list[tuple[float, float]]:
        """Return how much each value changes if all readings that raise it are too high by 1.

        The second array is the change if all readings that lower it are too high by 1.
        """
        up, down = np.zeros(len(found)), np.zeros(len(found))
        for rows in fitted.values.rows():
            moved = self._fitted(fitted.values.moved(column, rows, step))
            by = np.array([_any_change(one, moved) / step for one in found])
            up, down = up + np.maximum(by, 0.0), down + np.maximum(-by, 0.0)
        if column is None:
            by = np.array([one.by_asked for one in found])
            up, down = up + np.maximum(by, 0.0), down + np.maximum(-by, 0.0)
        return list(zip(up.tolist(), down.tolist(), strict=True))

    def _result(
        self,
        definition: ResultDefinition,
        wanted: ResultSettings,
        value: Derived,
        of_errors: Sequence[tuple[_Error | SharedLine, float, float]],
    ) -> MeasurementResult:
        shown = unit(definition.unit)
        is_level = isinstance(wanted, ValueAt | XAt)
        number = (value.value - (shown.offset if is_level else 0.0)) / shown.factor
        scatter = value.u / shown.factor
        components = [
            Component(
                name=SCATTER,
                u=scatter,
                dof=value.dof if value.dof > 0 else inf,
                distribution="t",
                common=False,
                unit=shown.symbol,
                input_u=scatter,
                sensitivity=1.0,
                of_points=self._points,
            ),
            *(
                error.of_result(name, effect)
                for error, up, down in of_errors
                for name, effect in _named(
                    error,
                    up / shown.factor,
                    down / shown.factor,
                    is_difference=value.is_difference,
                )
            ),
        ]
        u, dof = combine(components)
        if any(isnan(each.u) for each in components):
            u, dof = float("nan"), float("nan")
        kurtosis = excess_kurtosis(((each.u, each.distribution) for each in components), u)
        return MeasurementResult(
            of=definition,
            estimate=Estimate(number, u, dof, shown.symbol, kurtosis),
            components=tuple(components),
            coordinates=self.source.place,
            readings=len(self.source.values.y),
        )


def _change(one: Derived, moved: Fitted) -> float:
    """Return the change of a value; 0 for a rounding error, which depends on the machine."""
    change = _any_change(one, moved)
    return 0.0 if abs(change) <= ROUNDING * abs(one.value) else change


def _any_change(one: Derived, moved: Fitted) -> float:
    return one.again(moved) - one.value


def _named(
    error: _Error | SharedLine, up: float, down: float, *, is_difference: bool
) -> Iterator[tuple[str, float]]:
    """Yield the lines of an error with their effects, from what raises and lowers a result."""
    if error.is_one:
        yield error.name, up - down  # its sign counts where it is shared
    elif is_difference:
        # errors of two readings that are independent: a line for each
        yield f"{error.name}, falling", up
        yield f"{error.name}, rising", down
    else:
        yield error.name, up + down


@dataclass(frozen=True)
class _Error:
    """An error of a channel's readings."""

    channel: str
    unit: str
    error: ReadingError

    @property
    def name(self) -> str:
        """Its name, with its source if that is stated."""
        return f"{self.error.name} ({self.error.source})" if self.error.source else self.error.name

    @property
    def is_one(self) -> bool:
        """Whether it is the same error of all readings."""
        return self.error.acts != "each"

    def of_result(self, name: str, effect: float) -> Component:
        """Return a line of a result's budget from what an error of 1 changes it by."""
        return Component(
            name=name,
            u=abs(effect) * self.error.u,
            dof=self.error.dof,
            distribution=self.error.distribution,
            common=True,
            value=0.0,
            unit="1" if self.error.acts == "gain" else self.unit,
            input_u=self.error.u,
            sensitivity=effect,
            shared=self.is_one,
        )
