"""The measurement model of one result at one place: its inputs and its expression tree.

A reading is `mean (1 + gain) + offset + ...`. The mean has the scatter of the readings (type A),
and each error in the register is an input of its own (type B). Errors of one instrument are the
same wherever its channel is used; channels read together keep their observed correlation.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from itertools import combinations
from math import inf, isclose, isfinite, isnan, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Component, Distribution, Input, MeasurementModel, MeasurementResult, unit
from rigrunner.api.uncertainty import Line
from rigrunner.api.units import si_symbol
from rigrunner.signal.expression.evaluation import evaluated
from rigrunner.signal.expression.syntax import Expression, Name, Operation
from rigrunner.signal.propagation import sensitivities
from rigrunner_plugins.analyses.equation.kinds import written
from rigrunner_plugins.analyses.settings import unit_of_errors
from rigrunner_plugins.analyses.statistics import correlation_of_means, mean_scatter

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from rigrunner.api import Array, RunData
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner.api.findings import ResultPlace
    from rigrunner.signal.expression.syntax import Node
    from rigrunner_plugins.analyses.equation.settings import EquationSettings
    from rigrunner_plugins.analyses.equation.text import Model
    from rigrunner_plugins.analyses.settings import ResultSettings
    from rigrunner_plugins.analyses.sources import Group

_Total = dict[str, "Array"]
TOGETHER = "readings"
"""The name of the ensemble of means that were read together."""
SEVERAL = ", of several results"
"""Ends the name of a line of inputs whose correlation is not known."""


class CorrelationError(Exception):
    """How inputs are correlated is not known; the message says why."""


@dataclass(frozen=True)
class Effect:
    """An input that changes a quantity by `slope` (input - `at`); for a gain, times the reading."""

    name: str
    is_gain: bool = False
    slope: float = 1.0
    at: float = 0.0


@dataclass(frozen=True, eq=False)
class Tree:
    """An equation of a model as a function of its inputs, with its derivatives.

    Implements `rigrunner.api.uncertainty.Differentiable`. The result is in its stated unit.
    """

    model: Model
    wanted: str
    fixed: Mapping[str, float]
    """Values without uncertainty, in SI units."""
    effects: Mapping[str, tuple[Effect, ...]]
    """The effects on each channel or result, by its symbol in the model."""
    factor: float
    offset: float

    def __call__(self, inputs: Mapping[str, Array]) -> Array:
        """Return the result for trials, shape (n,)."""
        values = self._values(inputs)
        for each in self.model.equations:
            values[each.name] = evaluated(each.expression, values)[0]
        return np.asarray((values[self.wanted] - self.offset) / self.factor)

    def gradient(self, inputs: Mapping[str, Array]) -> Mapping[str, Array]:
        """Return the derivative with respect to each input for trials, shape (n,)."""
        values = self._values(inputs)
        totals: dict[str, _Total] = {name: {name: np.array(1.0)} for name in inputs}
        for name, effects in self.effects.items():
            own = totals.setdefault(name, {})
            mean = self._mean(name, inputs)
            gains = [each.name for each in effects if each.is_gain]
            if name in own:
                own[name] = 1.0 + np.asarray(sum(inputs[gain] for gain in gains))
            for each in effects:
                own[each.name] = mean if each.is_gain else np.array(each.slope)
        for equation in self.model.equations:
            names = equation.expression.names()
            value, slopes = evaluated(equation.expression, values, names)
            values[equation.name] = value
            total: _Total = {}
            for name, slope in slopes.items():
                for of, part in totals.get(name, {}).items():
                    total[of] = total.get(of, 0.0) + slope * part
            totals[equation.name] = total
        return {name: each / self.factor for name, each in totals[self.wanted].items()}

    def undefined(self, inputs: Mapping[str, Array]) -> str:
        """Return the innermost part of the equation that gives no finite number, as text."""
        values = self._values(inputs)
        parts = {each.name: each.expression for each in self.model.equations}
        for name, part in parts.items():
            values[name] = evaluated(part, values)[0]
        node: Node = Name(self.wanted, 0)
        while True:
            if isinstance(node, Name) and node.name in parts:
                node = parts[node.name].root
            inner = node.operands if isinstance(node, Operation) else ()
            bad = [
                each
                for each in inner
                if not np.isfinite(evaluated(Expression("", each), values)[0])
            ]
            if not bad:
                break
            node = bad[0]
        text = written(node)
        for name, literal in self.model.literals.items():
            text = re.sub(rf"\b{name}\b", str(literal), text)
        return text

    def _values(self, inputs: Mapping[str, Array]) -> dict[str, Array]:
        values: dict[str, Array] = {name: np.asarray(each) for name, each in self.fixed.items()}
        values |= inputs
        for name, effects in self.effects.items():
            mean = self._mean(name, inputs)
            total = mean
            for each in effects:
                moved = each.slope * (inputs[each.name] - each.at)
                total = total + moved * (mean if each.is_gain else 1.0)
            values[name] = total
        return values

    def _mean(self, name: str, inputs: Mapping[str, Array]) -> Array:
        return inputs[name] if name in inputs else np.asarray(self.fixed[name])


@dataclass
class Inputs:
    """The inputs of the model at one place, the same for all of its results."""

    inputs: list[Input] = field(default_factory=list)
    fixed: dict[str, float] = field(default_factory=dict)
    effects: dict[str, tuple[Effect, ...]] = field(default_factory=dict)
    r: dict[tuple[str, str], float] = field(default_factory=dict)
    """The correlation of two inputs, by their names."""
    own_lines: set[str] = field(default_factory=set)
    """Errors that may differ between readings, so other results do not share them."""
    at_place: set[str] = field(default_factory=set)
    """Errors of results that differ between places; other results share them at the same place."""
    unsure: dict[str, tuple[str, bool]] = field(default_factory=dict)
    """By its name, of what an input is, and whether it is a scatter: how much inputs of one thing
    have in common is not known. Errors of readings are equal or independent, a scatter of one curve
    has any correlation."""
    lines: dict[str, str] = field(default_factory=dict)
    """The budget line of each correlated input."""
    joint: dict[str, str] = field(default_factory=dict)
    """The result of each line of several correlated inputs, which another may not have too."""

    def tree(self, settings: EquationSettings, result: ResultSettings) -> Tree:
        """Return the equation of one result."""
        stated = unit(result.unit)
        return Tree(settings.parsed, settings.called(result), self.fixed, self.effects,
                    stated.factor, stated.offset)  # fmt: skip

    def model(self, tree: Tree) -> MeasurementModel:
        """Return the measurement model of one result."""
        inputs, r = self._at_worst(tree)
        names = [each.name for each in inputs]
        correlation = np.eye(len(names)) if r else None
        if correlation is not None:
            for (one, other), each in r.items():
                i, j = names.index(one), names.index(other)
                correlation[i, j] = correlation[j, i] = each
        lines = {each.line: Line(nan) for each in inputs if each.line}
        return MeasurementModel(tuple(inputs), tree, correlation, lines)

    def _at_worst(self, tree: Tree) -> tuple[list[Input], dict[tuple[str, str], float]]:
        """Return inputs and correlations; what is not known of these is as bad as it can be."""
        inputs, r = list(self.inputs), dict(self.r)
        model = MeasurementModel(tuple(inputs), tree)
        if len(self.unsure) <= 1 or not isfinite(model.value):  # one has nothing in common
            return inputs, r
        groups: dict[tuple[str, bool], dict[int, float]] = {}
        for row, (each, slope) in enumerate(zip(inputs, sensitivities(model), strict=True)):
            if each.name in self.unsure and each.name not in self.lines and slope:
                of, is_scatter = self.unsure[each.name]
                groups.setdefault((of, is_scatter or slope > 0), {})[row] = slope
        for (of, _), found in groups.items():
            if len(found) == 1:
                continue
            members = [inputs[row] for row in found]
            line = f"{of}{SEVERAL}{'' if max(found.values()) > 0 else ', lowering'}"
            dof = min(each.dof for each in members)
            for row, each in zip(found, members, strict=True):
                ensemble = line if dof < inf else ""
                inputs[row] = replace(each, dof=dof, line=line, ensemble=ensemble)
            for i, j in combinations(found, 2):
                r[inputs[i].name, inputs[j].name] = float(np.sign(found[i] * found[j]))
        return inputs, r

    def doubt(self, line: Component, name: str) -> None:
        """Note what is not known of the input of a line of a result."""
        if line.of_points:
            self.unsure[name] = line.of_points, True
        elif not line.shared:
            self.unsure[name] = line.name.partition(", of ")[0], False
        elif line.common and line.value == 0 and name != line.name:
            # An error that is stated as a share of the reading, and so of another size here.
            self.unsure |= dict.fromkeys((name, line.name), (line.name, False))

    def marked(self, line: Component) -> Component:
        """Return a line of a result's budget with what it may share with that of another."""
        several_of, is_several, _ = line.name.partition(SEVERAL)
        of, is_scatter = self.unsure.get(line.name, ("", False))
        if is_several:
            of, is_scatter = several_of, (several_of, True) in self.unsure.values()
        return replace(
            line,
            shared=line.name not in self.own_lines and (is_scatter or not is_several),
            at_place=line.name in self.at_place,
            of_points=of if is_scatter else "",
        )


def inputs_of(
    run: RunData,
    settings: EquationSettings,
    group: Group,
    results: Mapping[str, ResultPlace],
) -> Inputs:
    """Return the inputs of the model at one place.

    `results` are results of other analyses at this place, by their symbols in the model; one
    without a value is nan, and so is what is calculated from it. Raises CorrelationError for
    instruments that have no errors of one kind, and for results with the same correlated inputs.
    """
    found = Inputs()
    found.fixed |= {name: each.si for name, each in settings.parsed.literals.items()}
    _enter_readings(found, settings, group)
    errors = _enter_instruments(found, run, settings, group)
    for name, told in settings.constants.items():
        if told.standard_uncertainty:
            found.inputs.append(
                Input(
                    name,
                    told.value.si,
                    told.standard_uncertainty,
                    told.dof,
                    Distribution(told.shape),
                    si_symbol(told.value.dimension),
                    common=True,
                )
            )
        else:
            found.fixed[name] = told.value.si
    taken = {*settings.inputs, *settings.constants, *settings.parsed.literals}
    taken |= {each.name for each in settings.parsed.equations}
    for name, result in results.items():
        if isinstance(result, MeasurementResult):
            _enter_result(found, name, result, taken, group.place)
        else:
            found.fixed[name] = nan
    for each in settings.correlations:
        one, other = each.between
        if one in settings.constants:
            found.r[one, other] = each.r
        else:
            pairs = dict.fromkeys(_pairs(errors[one], errors[other]), each.r)
            if each.r and not pairs:
                known = [", ".join(e.name for e in errors[n]) or "none" for n in (one, other)]
                raise CorrelationError(
                    f"{one} and {other} are to be correlated, and the register has no errors of one"
                    f" kind for both instruments (for {one}: {known[0]}; for {other}: {known[1]})"
                )
            found.r |= pairs
    _group_correlated(found)
    for line in set(found.joint) & set(found.lines.values()):
        raise CorrelationError(_joint(line, found.joint[line], "the model"))
    return found


def _enter_readings(found: Inputs, settings: EquationSettings, group: Group) -> None:
    """Add the mean of each channel, with its scatter and the observed correlations."""
    scattered: dict[str, tuple[float, float]] = {}
    for name, told in settings.channels.items():
        values = group.values[told.of]
        if told.scatter is not None:
            dof = inf if told.degrees_of_freedom is None else told.degrees_of_freedom
            u = told.scatter.si / sqrt(len(values))
            shape = Distribution.T if dof < inf else Distribution.NORMAL
            found.inputs.append(
                Input(name, float(values.mean()), u, dof, shape, group.units[told.of])
            )
            continue
        scatter = mean_scatter(group.series(values))
        if scatter is None or scatter[0] == 0:
            found.fixed[name] = float(values.mean())
        else:
            scattered[name] = scatter
    together = len(scattered) > 1
    # Of one joint t distribution there is one number of degrees of freedom: the least.
    dof = min((dof for _, dof in scattered.values()), default=inf)
    for name, (u, own) in scattered.items():
        of = settings.inputs[name].of
        mean = float(group.values[of].mean())
        found.inputs.append(
            Input(name, mean, u, dof if together else own, Distribution.T, group.units[of],
                  ensemble=TOGETHER if together else "")
        )  # fmt: skip
    if together:
        names = list(scattered)
        r = correlation_of_means(
            [group.series(group.values[settings.inputs[name].of]) for name in names]
        )
        for i, one in enumerate(names):
            for j in range(i):
                # Rounding may leave a little more than 1.
                found.r[names[j], one] = float(np.clip(r[i, j], -1.0, 1.0))


def _enter_instruments(
    found: Inputs, run: RunData, settings: EquationSettings, group: Group
) -> dict[str, list[Input]]:
    """Add each error in the register, and of each zero; return the former by instrument."""
    known: dict[str, Input] = {}
    zeros: dict[str, Input] = {}
    by_input: dict[str, list[Input]] = {}
    for name, told in settings.channels.items():
        by_input[name], effects = [], list[Effect]()
        largest = float(np.abs(group.values[told.of]).max())
        exact = told.of in group.set_points and told.of not in run.instruments
        for error in run.reading_errors(told.of, largest) if told.instrument and not exact else ():
            called = f"{error.name} ({error.source})" if error.source else error.name
            symbol = "1" if error.acts == "gain" else unit_of_errors(group.units[told.of])
            one = known.setdefault(
                called,
                Input(called, 0.0, error.u, error.dof, Distribution(error.distribution), symbol,
                      common=True),
            )  # fmt: skip
            by_input[name].append(one)
            effects.append(Effect(called, is_gain=error.acts == "gain"))
            if error.acts == "each":
                found.own_lines.add(called)
                found.unsure[called] = called, False
        for error, which in group.zero_errors(run, told.of):
            symbol = unit_of_errors(group.units[told.of])
            zeros[error.name] = Input(error.name, 0.0, error.u, error.dof, Distribution.T, symbol,
                                      common=True)  # fmt: skip
            effects.append(Effect(error.name, slope=float(which.mean())))
        found.effects[name] = tuple(effects)
    found.inputs += [*known.values(), *zeros.values()]
    return by_input


def _enter_result(
    found: Inputs,
    name: str,
    result: MeasurementResult,
    taken: Collection[str],
    place: Mapping[str, CoordinateValue],
) -> None:
    """Add a result by its budget lines; a line that another input also has becomes one input.

    `taken` are the names used in the model itself. A result that holds at all places of the model,
    such as a zero reading, has the same error at all of them, also by its scatter.
    """
    stated, estimate = unit(result.of.unit), result.estimate
    found.fixed[name] = estimate.value * stated.factor + stated.offset
    of = result.coordinates
    differs = bool(place) and place.keys() <= of.keys()
    effects: list[Effect] = []
    for line in result.components or _whole(result):
        if line.u == 0:
            continue
        error = _error_of(line, is_here=of.keys() == place.keys())
        error = None if error is None else _shared(found, error, taken)
        slope, is_at_place = line.sensitivity * stated.factor, line.at_place
        # So `Inputs.model` marks the line of several correlated inputs: it has no value of its own.
        joint = line.common and line.shared and isnan(line.value) and line.sensitivity == 1
        may_differ = not line.shared or joint
        if error is None:
            part = _part_of(line, result, stated.factor, place, differs=differs)
            # It may be there by another result that is made of this one, or by another symbol.
            error = _shared(found, part, taken) or replace(part, name=f"{part.name}, as {name}")
            if error not in found.inputs:
                found.inputs.append(error)
            slope, is_at_place, may_differ = 1.0, differs, may_differ and differs
        if joint and found.joint.setdefault(line.name, result.name) != result.name:
            raise CorrelationError(_joint(line.name, found.joint[line.name], result.name))
        found.doubt(line, error.name)
        if is_at_place:
            found.at_place.add(error.name)
        if may_differ:
            found.own_lines.add(error.name)
        effects.append(Effect(error.name, slope=slope, at=error.value))
    found.effects[name] = tuple(effects)


def _error_of(line: Component, *, is_here: bool) -> Input | None:
    """Return the error of a line that another result may share; otherwise None.

    `is_here`: the result is one of the very place, so an error of this place is one of it.
    """
    stated = isfinite(line.value) and isfinite(line.input_u) and isfinite(line.sensitivity)
    is_shared = (line.common and line.shared) or (line.at_place and is_here)
    if not (is_shared and stated):
        return None
    return Input(line.name, line.value, line.input_u, line.dof, _shape(line), line.unit,
                 common=line.common)  # fmt: skip


def _shared(found: Inputs, error: Input, taken: Collection[str]) -> Input | None:
    """Return the input of an error that several results have; None if its name is of another."""
    for each in (error, replace(error, name=f"{error.name}, of results")):
        known = next((one for one in found.inputs if one.name == each.name), None)
        if known is None and each.name not in taken:
            found.inputs.append(each)
            return each
        # The degrees of freedom of a line that was propagated are rounded.
        if known and known == replace(each, dof=known.dof) and isclose(known.dof, each.dof):
            return known
    return None


def _joint(line: str, one: str, other: str) -> str:
    """Return why two results with the same correlated inputs are not combined."""
    return (
        f"'{line}' is a line of {one} and of {other}, and what they have in common of it is not"
        " known: write them as results of one equation"
    )


def _part_of(
    line: Component,
    result: MeasurementResult,
    factor: float,
    place: Mapping[str, CoordinateValue],
    *,
    differs: bool,
) -> Input:
    """Return a line as an error of this result only, in its SI unit."""
    apart = [
        f"{key} = {each}"
        for key, each in result.coordinates.items()
        if not (differs and key in place)
    ]
    at = f" at {', '.join(apart)}" if apart else ""
    symbol = si_symbol(unit(result.of.unit).dimension)
    name, u = f"{line.name}, of {result.name}{at}", line.u * factor
    return Input(name, 0.0, u, line.dof, _shape(line), symbol, common=line.common or not differs)


def _shape(line: Component) -> Distribution:
    is_known = line.distribution in set(Distribution)
    return Distribution(line.distribution) if is_known else Distribution.NORMAL


def _whole(result: MeasurementResult) -> tuple[Component, ...]:
    """Return the uncertainty of a result without a budget, as its only line."""
    estimate = result.estimate
    shape = Distribution.T if estimate.dof < inf else Distribution.NORMAL
    return (Component("uncertainty", estimate.u, estimate.dof, str(shape), common=False),)


def _pairs(one: Sequence[Input], other: Sequence[Input]) -> Iterator[tuple[str, str]]:
    """Yield pairs of like errors of two instruments: gain with gain, and so on."""
    for a in one:
        for b in other:
            sorts = [each.name.partition(" of ")[0] for each in (a, b)]
            if a.name != b.name and sorts[0] == sorts[1] and a.dof == b.dof:
                yield a.name, b.name


def _group_correlated(found: Inputs) -> None:
    """Give correlated inputs one common budget line and common degrees of freedom."""
    groups: list[set[str]] = []
    for pair in found.r:
        joined = [each for each in groups if each & set(pair)]
        groups = [each for each in groups if each not in joined]
        groups.append(set(pair).union(*joined))
    for group in groups:
        members = [each for each in found.inputs if each.name in group]
        names = [each.name for each in members]
        line = f"{', '.join(names[:-1])} and {names[-1]}"
        scatter = members[0].ensemble == TOGETHER
        line = f"scatter of {line}, read together" if scatter else f"{line}, correlated"
        ensemble = members[0].ensemble or (line if members[0].dof < inf else "")
        for each in members:
            found.lines[each.name] = line
            place = found.inputs.index(each)
            found.inputs[place] = Input(
                each.name, each.value, each.u, each.dof, each.distribution, each.unit,
                common=each.common, line=line, ensemble=ensemble,
            )  # fmt: skip
