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
from rigrunner_plugins.analyses.curve.points import STEP, Shares, sources
from rigrunner_plugins.analyses.curve.settings import (
    BothWays,
    Nonlinearity,
    Slope,
    ValueAt,
    XAt,
    ZeroReturn,
)
from rigrunner_plugins.analyses.sources import error_line, line_name

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
        curve_sources = (
            sources_of_results(run, self.settings, (*others, *lacking))
            if self.settings.is_of_results
            else sources(run, self.settings)
        )
        for source in curve_sources:
            curve = _CurveAtPlace(self.settings, self.fit, source)
            curve_results, errors = curve.results(notes)
            results += curve_results
            missing += [
                MissingResult(of=of, coordinates=source.place, why=str(errors[of.name]).rstrip("."))
                for of in self.settings.yields()
                if of.name in errors
            ]
            refused |= {name: e for name, e in errors.items() if isinstance(e, DataError)}
            if curve_results:
                curves.append((curve_results[0].place, curve.fitted))
                if len(self.settings.over) == 1:
                    figures.extend(curve.figures(curve_results[0].name))
        for name in refused.keys() - {result.name for result in results}:
            raise refused[name]
        order = {definition.name: index for index, definition in enumerate(self.settings.yields())}
        results.sort(key=lambda result: order[result.name])
        missing.sort(key=lambda result: order[result.name])
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
class _CurveAtPlace:
    settings: CurveSettings
    fit: Fit
    source: Source

    def results(self, notes: dict[str, None]) -> tuple[list[MeasurementResult], _Errors]:
        """Return the results, and by name why others have no value; add to the notes."""
        errors: _Errors = {}
        try:
            return list(self._results(self.fitted, errors, notes)), errors
        except DataError as error:  # the fit failed: there is no result
            return [], {definition.name: error for definition in self.settings.yields()} | errors

    def _results(
        self, fitted: Fitted, errors: _Errors, notes: dict[str, None]
    ) -> Iterator[MeasurementResult]:
        derived_values: list[tuple[ResultDefinition, ResultSettings, Derived]] = []
        for definition, (_, settings) in zip(
            self.settings.yields(), self.settings.results.all_of(), strict=True
        ):
            try:
                derived_value = self._derive(fitted, settings)
            except (OutOfRangeError, DataError) as error:
                errors[definition.name] = error
                continue
            derived_values.append((definition, settings, derived_value))
            if derived_value.note:
                notes[f"{definition.name}{self._place}: {derived_value.note}."] = None
        notes.update(dict.fromkeys(self._correlations(fitted)))
        for place in self.source.left_out:
            notes[
                f"{self.settings.of}: there is no point at {place}, where a value is missing."
            ] = None
        for name in self.source.exact:
            notes[f"{name} counts as exact: the register has no entry for it."] = None
        effects = self._effects(fitted, [value for _, _, value in derived_values])
        for index, (definition, settings, derived_value) in enumerate(derived_values):
            of_errors = [(error, *of_each[index]) for error, of_each in effects]
            yield self._result(definition, settings, derived_value, of_errors)

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
        parameters = list(self.settings.results.parameters)
        names, covariance = list(fitted.curve.names), fitted.curve.covariance
        for first, second in combinations(parameters, 2):
            i, k = names.index(first), names.index(second)
            r = covariance[i, k] / np.sqrt(covariance[i, i] * covariance[k, k])
            if isfinite(r):
                results = self.settings.results.parameters
                names_of_both = f"{results[first].name} and {results[second].name}"
                yield f"Correlation of {names_of_both}{self._place}: {r:.6f}."

    @property
    def _points(self) -> str:
        settings, where = self.settings, self.settings.where.items()
        at = "".join(f", {name} = {value}" for name, value in (*where, *self.source.place.items()))
        return f"{SCATTER} of {settings.of} over {' and '.join(settings.over.values())}{at}"

    @property
    def _place(self) -> str:
        place = ", ".join(f"{name} = {value}" for name, value in self.source.place.items())
        return f" at {place}" if place else ""

    def _fitted(self, values: Values) -> Fitted:
        return Fitted(values, self.fit(values.points()))

    def _derive(self, fitted: Fitted, settings: ResultSettings) -> Derived:
        if isinstance(settings, ValueAt):
            return derived.value_at(fitted, settings, self.settings.at(settings))
        if isinstance(settings, XAt):
            index = self.settings.results.x_at.index(settings)
            return derived.x_at(fitted, settings, index, self.source.counts[index])
        if isinstance(settings, Slope):
            return derived.slope(fitted, settings)
        if isinstance(settings, Nonlinearity):
            return derived.nonlinearity(fitted, settings)
        if isinstance(settings, BothWays):
            at_zero = isinstance(settings, ZeroReturn)
            places = self.source.places
            return derived.both_ways(fitted, settings, places, self.fit, at_zero=at_zero)
        parameters = self.settings.results.parameters
        name = next(key for key, parameter in parameters.items() if parameter is settings)
        self._check_unit(fitted, name, settings)
        return derived.parameter(fitted, name)

    def _check_unit(self, fitted: Fitted, name: str, settings: ResultSettings) -> None:
        """Raise DataError if a parameter's stated unit does not match the fit's dimension."""
        units = dict(zip(fitted.curve.names, fitted.curve.units, strict=True))
        symbol = units.get(name, "")
        fit_unit = find_unit(symbol)
        if fit_unit is None or symbol == "1":
            return
        if unit(settings.unit).dimension != fit_unit.dimension:
            raise DataError(
                f"{settings.name} is stated in {settings.unit}; the parameter '{name}' of the fit"
                f" is in {symbol}"
            )

    def _effects(
        self, fitted: Fitted, values: Sequence[Derived]
    ) -> list[tuple[_Error | SharedLine, list[tuple[float, float]]]]:
        """Return each error with its greatest effect on each value, upwards and downwards."""
        columns = {self.settings.of: None} | {
            name: column
            for column, name in enumerate(self.settings.over.values())
            if name in self.source.errors
        }
        effects: list[tuple[_Error | SharedLine, list[tuple[float, float]]]] = [
            (line, self._effects_of_line(fitted, values, line)) for line in self.source.lines
        ]
        for channel, errors in self.source.errors.items():
            column = columns[channel]
            step = STEP * float(fitted.values.ranges[0 if column is None else 1 + column])
            changes_of_each: list[tuple[float, float]] | None = None
            for error in errors:
                if error.acts == "each":
                    if changes_of_each is None:
                        changes_of_each = self._effects_of_each(fitted, values, column, step)
                    changes = changes_of_each
                else:
                    size = step
                    if error.acts == "gain":  # shifts the largest x by a step
                        largest = 0.0 if column is None else self._largest(column)
                        size = step / largest if largest else STEP
                    read = np.array([count > 0 for count in self.source.counts], np.float64)
                    shares = Shares(np.ones(len(fitted.values.y)), read)
                    changes = self._changes(
                        fitted, values, column, acts=error.acts, size=size, shares=shares
                    )
                effects.append((self._error(column, error), changes))
        for channel, error, shares in self.source.of_zeros:
            column = columns.get(channel)
            step = STEP * float(fitted.values.ranges[0 if column is None else 1 + column])
            changes = self._changes(
                fitted, values, column, acts=error.acts, size=step, shares=shares
            )
            effects.append((self._error(column, error), changes))
        return effects

    def _changes(
        self,
        fitted: Fitted,
        values: Sequence[Derived],
        column: int | None,
        *,
        acts: str,
        size: float,
        shares: Shares,
    ) -> list[tuple[float, float]]:
        """Return the change of each value, upwards and downwards, by an error of 1."""
        refitted = self._fitted(fitted.values.with_error(column, acts, size, shares))
        changes = [_change(value, refitted) / size for value in values]
        return [(max(change, 0.0), max(-change, 0.0)) for change in changes]

    def _error(self, column: int | None, error: ReadingError) -> _Error:
        values = self.source.values
        symbol = values.y_unit if column is None else values.units[column]
        return _Error(symbol, error)

    def _largest(self, column: int) -> float:
        values = self.source.values
        return float(np.abs(values.x[:, column] + values.origin).max())

    def _effects_of_line(
        self, fitted: Fitted, values: Sequence[Derived], line: SharedLine
    ) -> list[tuple[float, float]]:
        """Return how much each value rises and falls by one standard uncertainty of a line."""
        if not np.isfinite(line.by).all():  # of an instrument that the register does not have
            return [(nan, nan)] * len(values)
        up, down = np.zeros(len(values)), np.zeros(len(values))
        for rows in (slice(None),) if line.line.shared else fitted.values.rows():
            points, share = fitted.values.shifted_by(line.by, rows)
            refitted = self._fitted(points)
            change = _change if line.line.shared else _any_change
            changes = np.array([change(value, refitted) / share for value in values])
            up, down = up + np.maximum(changes, 0.0), down + np.maximum(-changes, 0.0)
        return list(zip(up.tolist(), down.tolist(), strict=True))

    def _effects_of_each(
        self, fitted: Fitted, values: Sequence[Derived], column: int | None, step: float
    ) -> list[tuple[float, float]]:
        """Return how much each value changes if all readings that raise it are too high by 1.

        The second array is the change if all readings that lower it are too high by 1.
        """
        up, down = np.zeros(len(values)), np.zeros(len(values))
        for rows in fitted.values.rows():
            refitted = self._fitted(fitted.values.shifted(column, rows, step))
            changes = np.array([_any_change(value, refitted) / step for value in values])
            up, down = up + np.maximum(changes, 0.0), down + np.maximum(-changes, 0.0)
        if column is None:
            changes = np.array([value.by_requested_y for value in values])
            up, down = up + np.maximum(changes, 0.0), down + np.maximum(-changes, 0.0)
        return list(zip(up.tolist(), down.tolist(), strict=True))

    def _result(
        self,
        definition: ResultDefinition,
        settings: ResultSettings,
        value: Derived,
        of_errors: Sequence[tuple[_Error | SharedLine, float, float]],
    ) -> MeasurementResult:
        shown = unit(definition.unit)
        is_level = isinstance(settings, ValueAt | XAt)
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
                for name, effect in _line_effects(
                    error,
                    up / shown.factor,
                    down / shown.factor,
                    is_difference=value.is_difference,
                )
            ),
        ]
        u, dof = combine(components)
        if any(isnan(line.u) for line in components):
            u, dof = float("nan"), float("nan")
        kurtosis = excess_kurtosis(((line.u, line.distribution) for line in components), u)
        return MeasurementResult(
            of=definition,
            estimate=Estimate(number, u, dof, shown.symbol, kurtosis),
            components=tuple(components),
            coordinates=self.source.place,
            readings=len(self.source.values.y),
        )


def _change(value: Derived, refitted: Fitted) -> float:
    """Return the change of a value; 0 for a rounding error, which depends on the machine."""
    change = _any_change(value, refitted)
    return 0.0 if abs(change) <= ROUNDING * abs(value.value) else change


def _any_change(value: Derived, refitted: Fitted) -> float:
    return value.recompute(refitted) - value.value


def _line_effects(
    error: _Error | SharedLine, up: float, down: float, *, is_difference: bool
) -> Iterator[tuple[str, float]]:
    """Yield the lines of an error with their effects, from what raises and lowers a result."""
    if error.is_one_error:
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

    unit: str
    """The SI unit of the readings."""
    error: ReadingError

    @property
    def name(self) -> str:
        """Its name, with its source if that is stated."""
        return line_name(self.error)

    @property
    def is_one_error(self) -> bool:
        """Whether it is the same error of all readings."""
        return self.error.acts != "each"

    def of_result(self, name: str, effect: float) -> Component:
        """Return a line of a result's budget from what an error of 1 changes it by."""
        return error_line(self.error, name, effect, self.unit)
