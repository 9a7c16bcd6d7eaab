"""What plugins of the analysis give, looked at before it is used, and what they may not change.

A number that is none, a point that is left out or an array that was changed in place would else
reach the verdict unseen. What is wrong is a PluginError that names the plugin.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from itertools import chain, pairwise
from operator import index
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from rigrunner.analysis.lookup import fits_in
from rigrunner.api.analysis import CompensatedPoint, Compensation, Rejection
from rigrunner.api.data import Estimate
from rigrunner.api.errors import PluginError, RigrunnerError
from rigrunner.api.findings import Findings
from rigrunner.api.verdict import WORST_FIRST, Verdict, Zone
from rigrunner.signal.expression.syntax import ExpressionError, parse_any
from rigrunner.signal.propagation import propagate
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner.analysis.lookup import Lookup
    from rigrunner.api.analysis import (
        CompensationMethod,
        Curve,
        Fit,
        OutlierRule,
        PeakPoint,
        Requirements,
        Sweep,
    )
    from rigrunner.api.data import Array, Points, RunData
    from rigrunner.api.findings import (
        Analysis,
        AnalysisOfResults,
        MeasurementResult,
        ResultDefinition,
    )
    from rigrunner.api.measurand import MeasurandKind
    from rigrunner.api.settings import Settings
    from rigrunner.api.verdict import DecisionRule, Limits

UNIT = "N·m"
_ROUNDING = 1e-9
"""How far a torque may be from what its own model gives, of either."""
_LONGEST = 80
"""Characters of a value in a message."""


@dataclass(frozen=True)
class Scrutiny:
    """A Lookup whose plugins are given what they cannot change, and give what can be used."""

    lookup: Lookup

    def make(self, kind: str, name: str, settings: Mapping[str, Any], **fits: Fit) -> Any:
        """Return the callable of a kind such as 'fit' or 'decision_rule'; raise PluginError.

        `fits`: as for a Lookup; those that are not given are looked at too.
        """
        subject = _Subject(kind, name)
        if kind == "analysis":
            for at, fit in fits_in(self.lookup, name, settings).items():
                fits.setdefault(at, self.make("fit", fit.name, fit.settings))
            made = self.lookup.make(kind, name, settings, **fits)
            due = self.lookup.definitions(name, settings)
            return _Analysis(subject, made, {each.name: each for each in due})
        made = self.lookup.make(kind, name, settings)
        return _CHECKED[kind](subject, made)

    def definitions(self, name: str, settings: Mapping[str, Any]) -> tuple[ResultDefinition, ...]:
        """Return the results of an analysis by its settings; raise PluginError."""
        return self.lookup.definitions(name, settings)

    def settings_of(self, kind: str, name: str) -> type[Settings]:
        """Return the settings model of a plugin; raise PluginError."""
        return self.lookup.settings_of(kind, name)

    def yields(self, compensation: str) -> MeasurandKind | None:
        """Return which torque a compensation yields, if its plugin says."""
        return self.lookup.yields(compensation)

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return what a plugin of the analysis needs of a run; raise PluginError."""
        return self.lookup.requires(kind, name, settings)

    def revision(self, kind: str, name: str) -> int:
        """Return the revision of an installed plugin; raise PluginError."""
        return self.lookup.revision(kind, name)


@dataclass(frozen=True)
class _Subject:
    """Which plugin it is about."""

    kind: str
    name: str

    @contextmanager
    def named(self) -> Iterator[None]:
        """Let whatever its author did not foresee name the plugin."""
        try:
            yield
        except RigrunnerError:
            raise
        except Exception as error:
            error.add_note(f"in the {self.kind.replace('_', ' ')} '{self.name}'")
            raise

    def refuse(self, what: str) -> NoReturn:
        """Raise the PluginError."""
        kind = self.kind.replace("_", " ")
        hint = f"its author is to fix that; see 'rigrunner check-plugin {self.name}'"
        raise PluginError(f"the {kind} '{self.name}' gave {what}", hint=hint)

    def need(self, holds: bool, what: str) -> None:  # noqa: FBT001  (reads as a sentence)
        """Raise the PluginError unless it holds."""
        if not holds:
            self.refuse(what)


@dataclass(frozen=True)
class _Rule:
    subject: _Subject
    rule: OutlierRule

    def __call__(self, values: Array) -> tuple[Rejection, ...]:
        _protect(values)
        with self.subject.named():
            found = self.rule(values)
        self.subject.need(isinstance(found, (list, tuple)), f"{_shown(found)}, expected a list")
        rejections = tuple(self._checked(each, values) for each in found)
        indices = [each.index for each in rejections]
        self.subject.need(len(set(indices)) == len(indices), "one rejection twice")
        return rejections

    def _checked(self, found: object, values: Array) -> Rejection:
        if not isinstance(found, Rejection):
            self.subject.refuse(f"{_shown(found)}, expected a Rejection")
        whole = not isinstance(found.index, bool) and hasattr(found.index, "__index__")
        inside = whole and 0 <= found.index < len(values)
        self.subject.need(inside, f"the index {found.index!r} of {len(values)} values")
        numbers = (found.value, found.statistic, found.critical)
        self.subject.need(all(map(_is_real, numbers)), f"a rejection of {_shown(numbers)}")
        value, statistic, critical = map(float, numbers)
        return Rejection(index(found.index), value, found.rule, statistic, critical)


@dataclass(frozen=True)
class _Fit:
    subject: _Subject
    fit: Fit

    def __call__(self, points: Points) -> Curve:
        _protect(points.x, points.y, points.u_y)
        with self.subject.named():
            curve = self.fit(points)
        try:
            self._check(curve, points)
        except (AttributeError, TypeError, ValueError) as error:
            self.subject.refuse(f"{_shown(curve)}, which is not a curve: {error}")
        return curve

    def _check(self, curve: Curve, points: Points) -> None:
        need, count = self.subject.need, len(curve.coefficients)
        coefficients, covariance = curve.coefficients, curve.covariance
        need(_are_numbers(coefficients, (count,)), f"the coefficients {_shown(coefficients)}")
        need(_are_numbers(covariance, (count, count)), f"the covariance {_shown(covariance)}")
        variances = np.diag(covariance)
        need(bool(np.all(variances >= 0)), f"the negative variances {_shown(variances)}")
        named = len(curve.names), len(curve.units)
        need(named == (count, count), f"{named} names and units of {count} coefficients")
        need(_are_numbers(curve.residuals, points.y.shape), "residuals that are not one a point")
        low, high = curve.valid_x
        need(low <= high, f"the validity range {low} to {high}")
        first = points.x[:, 0] if points.regressors else points.x
        x = points.x[(first >= low) & (first <= high)]
        y, u = curve.predict(x)
        need(_are_numbers(y, x.shape[:1]), f"the prediction {_shown(y)}")
        sure = _are_numbers(u, x.shape[:1]) and bool(np.all(np.asarray(u) >= 0))
        need(sure, f"the uncertainty {_shown(u)} of its prediction")


@dataclass(frozen=True)
class _Method:
    subject: _Subject
    method: CompensationMethod

    def __call__(self, sweep: Sweep) -> Compensation:
        for prepared in (*sweep.loaded, *sweep.no_load):
            _protect(*_arrays(prepared))
        with self.subject.named():
            found = self.method(sweep)
        need = self.subject.need
        if not isinstance(found, Compensation):
            self.subject.refuse(f"{_shown(found)}, expected a Compensation")
        if found.not_applicable:
            need(not found.points, "points, and says that it is not applicable")
            return found
        self._check_places(found.points, sweep.loaded)
        for point in found.points:
            self._check(point)
        return replace(found, points=tuple(found.points))

    def _check_places(
        self, points: Sequence[CompensatedPoint], loaded: Sequence[PeakPoint]
    ) -> None:
        for point in points:
            if not isinstance(point, CompensatedPoint):  # its arrays are told only where needed
                self.subject.refuse(f"{_shown(point)}, expected a CompensatedPoint")
        given = [point.set_frequency_hz for point in points]
        due = [point.set_frequency_hz for point in loaded]
        self.subject.need(
            given == due, f"points at {_hertz(given)}; expected one for each of {_hertz(due)}"
        )

    def _check(self, point: CompensatedPoint) -> None:
        need, at = self.subject.need, f"at {point.set_frequency_hz:g} Hz"
        torque = point.torque
        need(isinstance(torque, Estimate), f"the torque {_shown(torque)} {at}, no Estimate")
        need(torque.unit == UNIT, f"a torque in '{torque.unit}' {at}, expected {UNIT}")
        values = (torque.value, point.raw_nm, point.rig_nm, point.frequency_hz)
        need(all(map(_is_finite, values)), f"torque, raw, rig and frequency {_shown(values)} {at}")
        u, dof = torque.u, torque.dof
        need(_is_real(u) and (math.isnan(u) or 0 <= u < math.inf), f"the uncertainty {u!r} {at}")
        need(_is_real(dof) and (math.isnan(dof) or dof > 0), f"{dof!r} degrees of freedom {at}")
        if point.model is not None:
            modelled = propagate(point.model).estimate
            for name in ("value", "u", "dof"):
                given, due = getattr(torque, name), getattr(modelled, name)
                agrees = math.isclose(given, due, rel_tol=_ROUNDING, abs_tol=_ROUNDING * u)
                unknown = math.isnan(given) and math.isnan(due)
                need(
                    agrees or unknown,
                    f"a torque {at} whose {name} is {given:g}, by its own model {due:g}",
                )


@dataclass(frozen=True)
class _Verdicts:
    subject: _Subject
    rule: DecisionRule

    @property
    def words(self) -> Mapping[str, str]:
        words = self.rule.words
        told = isinstance(words, Mapping) and all(
            isinstance(each, str) and each for each in (*words, *words.values())
        )
        self.subject.need(
            told and "en" in words, f"the words {_shown(words)}, expected {{'en': ...}}"
        )
        return words

    def __call__(self, limits: Limits, estimate: Estimate) -> tuple[Zone, ...]:
        refuse = self.subject.refuse
        with self.subject.named():
            found = self.rule(limits, estimate)
        if not (isinstance(found, (list, tuple)) and found):
            refuse(f"{_shown(found)}, expected zones")
        for each in found:
            if not isinstance(each, Zone):
                refuse(f"{_shown(each)}, expected a Zone")
            if not _is_finite(each.margin):
                refuse(f"the margin {each.margin!r} of a zone")
            if each.verdict not in WORST_FIRST or each.verdict is Verdict.FAIL:
                refuse(f"the verdict {_shown(each.verdict)} of a zone")
        for better, worse in pairwise(found):
            if better.margin <= worse.margin:
                refuse(f"zones whose margins do not fall: {better.margin:g}, {worse.margin:g}")
            if WORST_FIRST.index(better.verdict) <= WORST_FIRST.index(worse.verdict):
                refuse(f"'{worse.verdict}' farther out than '{better.verdict}', which is worse")
        return tuple(found)


@dataclass(frozen=True)
class _Analysis:
    subject: _Subject
    analysis: Analysis | AnalysisOfResults
    yields: Mapping[str, ResultDefinition]

    def __call__(self, run: RunData, *results: Sequence[MeasurementResult]) -> Findings:
        for recording in run.recordings:
            _protect(*recording.channels.values())
        with self.subject.named():
            found = self.analysis(run, *results)
        need = self.subject.need
        if not isinstance(found, Findings):
            self.subject.refuse(f"{_shown(found)}, expected Findings")
        places = [(each.name, each.place) for each in found.results]
        need(len(set(places)) == len(places), "two results of one name and place")
        means = [each.name for each in found.means]
        need(len(set(means)) == len(means), "two means of one name")
        for each in (*found.results, *found.means):
            self._check(each)
        for formula in chain(found.formulas, *(each.formulas for each in found.sections)):
            try:
                parse_any(formula.text)
            except ExpressionError as error:
                self.subject.refuse(f"the formula {_shown(formula.text)}: {error.message}")
        for table in chain(found.tables, *(each.tables for each in found.sections)):
            wide = {len(row) for row in table.rows} | {len(table.columns)}
            need(len(wide) == 1, f"the table '{table.title}' with rows of {wide} columns")
        return found

    def _check(self, result: MeasurementResult) -> None:
        need, estimate = self.subject.need, result.estimate
        due = self.yields.get(result.name)
        need(due == result.of, f"the result '{result.name}', which its record does not yield")
        need(
            estimate.unit == result.of.unit,
            f"'{result.name}' in '{estimate.unit}', stated in '{result.of.unit}'",
        )
        u, dof = estimate.u, estimate.dof
        need(_is_finite(estimate.value), f"'{result.name}' of {_shown(estimate.value)}")
        need(_is_real(u) and (math.isnan(u) or 0 <= u < math.inf), f"the uncertainty {u!r}")
        need(_is_real(dof) and (math.isnan(dof) or dof > 0), f"{dof!r} degrees of freedom")
        if result.components and not math.isnan(u):
            by_lines, _ = combine(result.components)
            agrees = math.isclose(by_lines, u, rel_tol=_ROUNDING)
            need(agrees, f"'{result.name}' with u = {u:g}, by its budget {by_lines:g}")


_CHECKED = {
    "outlier_rule": _Rule,
    "fit": _Fit,
    "compensation": _Method,
    "decision_rule": _Verdicts,
}


def _arrays(point: PeakPoint) -> Iterable[object]:
    return (getattr(point, each.name) for each in fields(point))


def _protect(*arrays: object) -> None:
    """Let nobody write into arrays that others use too."""
    for array in arrays:
        if isinstance(array, np.ndarray):
            array.flags.writeable = False


def _are_numbers(values: object, shape: tuple[int, ...]) -> bool:
    array = np.asarray(values)
    return array.shape == shape and array.dtype.kind in "fiu" and bool(np.isfinite(array).all())


def _is_real(value: object) -> bool:
    return isinstance(value, (float, int, np.floating, np.integer)) and not isinstance(value, bool)


def _is_finite(value: object) -> bool:
    return _is_real(value) and math.isfinite(value)  # type: ignore[arg-type]  # a number


def _hertz(frequencies: Iterable[float]) -> str:
    named = ", ".join(f"{each:g}" for each in frequencies)
    return f"{named} Hz" if named else "no frequency"


def _shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
