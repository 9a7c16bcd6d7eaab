"""Checks what plugins of the analysis return before it is used, and write-protects their inputs.

Otherwise a value that is no number, a missing point or an array changed in place would reach the
verdict unnoticed. Such an error is a PluginError that names the plugin.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from itertools import chain, pairwise
from operator import index
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.analysis import Rejection
from rigrunner.api.analysis_context import AnalysisContext
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.findings import Findings
from rigrunner.api.fit_choice import chosen_fits
from rigrunner.api.scrutiny import Subject, are_numbers, is_finite, is_real, protect, shown
from rigrunner.api.verdict import WORST_FIRST, Verdict, Zone
from rigrunner.signal.expression.syntax import ExpressionError, parse_any
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from rigrunner.api.analysis import Curve, Fit, OutlierRule, Requirements
    from rigrunner.api.data import Array, Estimate, Points, RunData
    from rigrunner.api.findings import (
        Analysis,
        AnalysisOfResults,
        MeasurementResult,
        ResultDefinition,
        ResultPlace,
    )
    from rigrunner.api.hooks import PluginRecord
    from rigrunner.api.verdict import DecisionRule, Limits
    from rigrunner.registry import Registry

_ROUNDING = 1e-9
"""Allowed relative difference of an uncertainty from that of its own budget."""


@dataclass(frozen=True)
class Scrutiny:
    """The plugins of a registry, with write-protected data and checked outputs."""

    registry: Registry

    def make(
        self,
        kind: str,
        name: str,
        settings: Mapping[str, Any],
        context: AnalysisContext | None = None,
        **fits: Fit,
    ) -> Any:
        """Return the callable of a kind such as 'fit' or 'decision_rule'; raise PluginError.

        `fits`: as for a registry; those left out are checked too. Whoever makes plugins of a
        kind that another package defines checks what they return.
        """
        subject = Subject(kind, name)
        if kind == "analysis":
            for at, fit in chosen_fits(self.registry.validated(kind, name, settings)).items():
                fits.setdefault(at, self.make("fit", fit.name, fit.settings))
            context = context or AnalysisContext(plugins=self)
            made = self.registry.make(kind, name, settings, context, **fits)
            definitions = self.registry.definitions(name, settings, context)
            return _Analysis(subject, made, {each.name: each for each in definitions})
        made = self.registry.make(kind, name, settings)
        return _CHECKED[kind](subject, made) if kind in _CHECKED else made

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return what a plugin declares; raise PluginError."""
        return self.registry.record(kind, name)

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return what a plugin of the analysis needs of a run; raise PluginError."""
        return self.registry.requires(kind, name, settings)


@dataclass(frozen=True)
class _Rule:
    subject: Subject
    rule: OutlierRule

    def __call__(self, values: Array) -> tuple[Rejection, ...]:
        protect(values)
        with self.subject.named():
            output = self.rule(values)
        self.subject.need(isinstance(output, (list, tuple)), f"{shown(output)}, expected a list")
        rejections = tuple(self._checked(item, values) for item in output)
        indices = [rejection.index for rejection in rejections]
        self.subject.need(len(set(indices)) == len(indices), "one rejection twice")
        return rejections

    def _checked(self, rejection: object, values: Array) -> Rejection:
        if not isinstance(rejection, Rejection):
            self.subject.refuse(f"{shown(rejection)}, expected a Rejection")
        # A bool is an index to Python: True would leave out the second value.
        is_integer = not isinstance(rejection.index, bool) and hasattr(rejection.index, "__index__")
        is_index = is_integer and 0 <= rejection.index < len(values)
        self.subject.need(is_index, f"the index {rejection.index!r} of {len(values)} values")
        numbers = (rejection.value, rejection.statistic, rejection.critical)
        self.subject.need(all(map(is_real, numbers)), f"a rejection of {shown(numbers)}")
        value, statistic, critical = map(float, numbers)
        return Rejection(index(rejection.index), value, rejection.rule, statistic, critical)


@dataclass(frozen=True)
class _Fit:
    subject: Subject
    fit: Fit

    def __call__(self, points: Points) -> Curve:
        protect(points.x, points.y, points.u_y)
        with self.subject.named():
            curve = self.fit(points)
        try:
            self._check(curve, points)
        except (AttributeError, TypeError, ValueError) as error:
            self.subject.refuse(f"{shown(curve)}, which is not a curve: {error}")
        return curve

    def _check(self, curve: Curve, points: Points) -> None:
        need, count = self.subject.need, len(curve.coefficients)
        coefficients, covariance = curve.coefficients, curve.covariance
        need(are_numbers(coefficients, (count,)), f"the coefficients {shown(coefficients)}")
        need(are_numbers(covariance, (count, count)), f"the covariance {shown(covariance)}")
        variances = np.diag(covariance)
        need(bool(np.all(variances >= 0)), f"the negative variances {shown(variances)}")
        counts = len(curve.names), len(curve.units)
        need(counts == (count, count), f"{counts} names and units of {count} coefficients")
        need(are_numbers(curve.residuals, points.y.shape), "residuals that are not one a point")
        low, high = curve.valid_x
        need(low <= high, f"the validity range {low} to {high}")
        first = points.x[:, 0] if points.regressors else points.x
        x = points.x[(first >= low) & (first <= high)]
        y, u = curve.predict(x)
        need(are_numbers(y, x.shape[:1]), f"the prediction {shown(y)}")
        is_valid = are_numbers(u, x.shape[:1]) and bool(np.all(np.asarray(u) >= 0))
        need(is_valid, f"the uncertainty {shown(u)} of its prediction")


@dataclass(frozen=True)
class _Verdicts:
    subject: Subject
    rule: DecisionRule

    @property
    def words(self) -> Mapping[str, str]:
        words = self.rule.words
        is_valid = (
            isinstance(words, Mapping)
            and "en" in words
            and all(isinstance(text, str) and text for text in (*words, *words.values()))
        )
        self.subject.need(is_valid, f"the words {shown(words)}, expected {{'en': ...}}")
        return words

    def __call__(self, limits: Limits, estimate: Estimate) -> tuple[Zone, ...]:
        refuse = self.subject.refuse
        with self.subject.named():
            zones = self.rule(limits, estimate)
        if not (isinstance(zones, (list, tuple)) and zones):
            refuse(f"{shown(zones)}, expected zones")
        for zone in zones:
            if not isinstance(zone, Zone):
                refuse(f"{shown(zone)}, expected a Zone")
            if not is_finite(zone.margin):
                refuse(f"the margin {zone.margin!r} of a zone")
            if zone.verdict not in WORST_FIRST or zone.verdict is Verdict.FAIL:
                refuse(f"the verdict {shown(zone.verdict)} of a zone")
        for better, worse in pairwise(zones):
            if better.margin <= worse.margin:
                refuse(f"zones whose margins do not fall: {better.margin:g}, {worse.margin:g}")
            if WORST_FIRST.index(better.verdict) <= WORST_FIRST.index(worse.verdict):
                refuse(f"'{worse.verdict}' farther out than '{better.verdict}', which is worse")
        return tuple(zones)


@dataclass(frozen=True)
class _Analysis:
    subject: Subject
    analysis: Analysis | AnalysisOfResults
    yields: Mapping[str, ResultDefinition]

    def __call__(self, run: RunData, *inputs: Any) -> Findings:
        for recording in run.recordings:
            protect(*recording.channels.values())
        with self.subject.named():
            findings = self.analysis(run, *inputs)
        need = self.subject.need
        if not isinstance(findings, Findings):
            self.subject.refuse(f"{shown(findings)}, expected Findings")
        for field in fields(findings):
            values = getattr(findings, field.name)
            if not isinstance(values, (tuple, list)):
                self.subject.refuse(f"{shown(values)} as {field.name}")
        for place in (*findings.results, *findings.missing):
            self._check_place(place)
        shown_by_itself = {name for details in findings.details for name in details.shown_results}
        places = [
            (result.name, result.place)
            for result in (*findings.results, *findings.missing)
            if result.name not in shown_by_itself
        ]
        need(len(set(places)) == len(places), "two results of one name and place")
        means = [result.name for result in findings.means]
        need(len(set(means)) == len(means), "two means of one name")
        for result in (*findings.results, *findings.means):
            self._check(result)
        for missing in findings.missing:
            self._check_definition(missing.of)
            if not isinstance(missing.why, str):
                self.subject.refuse(f"{shown(missing.why)} as the reason for a missing result")
        self._check_mathematics(findings)
        return findings

    def _check_mathematics(self, findings: Findings) -> None:
        need = self.subject.need
        for formula in chain(findings.formulas, *(each.formulas for each in findings.sections)):
            try:
                parse_any(formula.text)
            except ExpressionError as error:
                self.subject.refuse(f"the formula {shown(formula.text)}: {error.message}")
        for table in chain(findings.tables, *(each.tables for each in findings.sections)):
            widths = {len(row) for row in table.rows} | {len(table.columns)}
            need(len(widths) == 1, f"the table '{table.title}' with rows of {widths} columns")
            for cell in chain(*table.rows):
                if not (isinstance(cell, str) or is_real(cell)):
                    self.subject.refuse(f"the table '{table.title}' with {shown(cell)} in a cell")

    def _check(self, result: MeasurementResult) -> None:
        need, estimate = self.subject.need, result.estimate
        self._check_definition(result.of)
        need(
            estimate.unit == result.of.unit,
            f"'{result.name}' in '{estimate.unit}', stated in '{result.of.unit}'",
        )
        u, dof = estimate.u, estimate.dof
        need(is_finite(estimate.value), f"'{result.name}' of {shown(estimate.value)}")
        # nan is allowed: an uncertainty that is not known.
        need(is_real(u) and (math.isnan(u) or 0 <= u < math.inf), f"the uncertainty {u!r}")
        need(is_real(dof) and (math.isnan(dof) or dof > 0), f"{dof!r} degrees of freedom")
        count = result.readings
        is_count = isinstance(count, (int, np.integer)) and count >= 0
        need(is_count, f"'{result.name}' of {shown(count)} readings")
        for line in result.components:
            # nan passes: a line whose contribution is not known makes u unknown.
            need(
                is_real(line.u) and not line.u < 0 and is_real(line.dof) and not line.dof <= 0,
                f"a budget line '{line.name}' with u = {line.u!r}, {line.dof!r} degrees of freedom",
            )
        if result.components and not math.isnan(u):
            by_lines, _ = combine(result.components)
            agrees = math.isclose(by_lines, u, rel_tol=_ROUNDING)
            need(agrees, f"'{result.name}' with u = {u:g}, by its budget {by_lines:g}")

    def _check_place(self, place: ResultPlace) -> None:
        need = self.subject.need
        for name in place.of.per:
            need(name in place.coordinates, f"'{place.name}' without its coordinate '{name}'")
        for name, at in place.coordinates.items():
            if not isinstance(at, CoordinateValue) or not (
                isinstance(at.value, str) or is_finite(at.value)
            ):
                message = f"'{place.name}' at {name} = {shown(at)}, expected a CoordinateValue"
                self.subject.refuse(message)

    def _check_definition(self, definition: ResultDefinition) -> None:
        name = definition.name
        is_declared = self.yields.get(name) == definition
        self.subject.need(is_declared, f"the result '{name}', which its record does not yield")


_CHECKED = {
    "outlier_rule": _Rule,
    "fit": _Fit,
    "decision_rule": _Verdicts,
}
