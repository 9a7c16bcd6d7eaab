"""The inputs of a measurement model at one place, and how they are correlated."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations
from math import inf, isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Component, Input, MeasurementModel, unit
from rigrunner.api.uncertainty import Line
from rigrunner.signal.propagation import sensitivities
from rigrunner_plugins.analyses.equation.settings import symbol_of
from rigrunner_plugins.analyses.equation.tree import Effect, Tree

if TYPE_CHECKING:
    from rigrunner_plugins.analyses.equation.settings import EquationSettings
    from rigrunner_plugins.analyses.settings import ResultSettings

SEVERAL = ", of several results"
"""Ends the name of a line of inputs whose correlation is not known."""


class CorrelationError(Exception):
    """How inputs are correlated is not known; the message says why."""


@dataclass
class Inputs:
    """The inputs of the model at one place, the same for all of its results."""

    inputs: list[Input] = field(default_factory=list)
    fixed: dict[str, float] = field(default_factory=dict)
    effects: dict[str, tuple[Effect, ...]] = field(default_factory=dict)
    r: dict[tuple[str, str], float] = field(default_factory=dict)
    """The correlation of two inputs, by their names."""
    unshared: set[str] = field(default_factory=set)
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
        result_unit = unit(result.unit)
        return Tree(settings.parsed, symbol_of(result), self.fixed, self.effects,
                    result_unit.factor, result_unit.offset)  # fmt: skip

    def model(self, tree: Tree) -> MeasurementModel:
        """Return the measurement model of one result."""
        inputs, r = self._worst_case(tree)
        names = [member.name for member in inputs]
        correlation = np.eye(len(names)) if r else None
        if correlation is not None:
            for (one, other), coefficient in r.items():
                i, j = names.index(one), names.index(other)
                correlation[i, j] = correlation[j, i] = coefficient
        lines = {member.line: Line(nan) for member in inputs if member.line}
        return MeasurementModel(tuple(inputs), tree, correlation, lines)

    def _worst_case(self, tree: Tree) -> tuple[list[Input], dict[tuple[str, str], float]]:
        """Return inputs and correlations; unknown correlations get their worst possible value."""
        inputs, r = list(self.inputs), dict(self.r)
        model = MeasurementModel(tuple(inputs), tree)
        if len(self.unsure) <= 1 or not isfinite(model.value):  # one has nothing in common
            return inputs, r
        groups: dict[tuple[str, bool], dict[int, float]] = {}
        for row, (member, slope) in enumerate(zip(inputs, sensitivities(model), strict=True)):
            if member.name in self.unsure and member.name not in self.lines and slope:
                source, is_scatter = self.unsure[member.name]
                groups.setdefault((source, is_scatter or slope > 0), {})[row] = slope
        for (source, _), slopes in groups.items():
            if len(slopes) == 1:
                continue
            members = [inputs[row] for row in slopes]
            line = f"{source}{SEVERAL}{'' if max(slopes.values()) > 0 else ', lowering'}"
            dof = min(member.dof for member in members)
            for row, member in zip(slopes, members, strict=True):
                ensemble = line if dof < inf else ""
                inputs[row] = replace(member, dof=dof, line=line, ensemble=ensemble)
            for i, j in combinations(slopes, 2):
                r[inputs[i].name, inputs[j].name] = float(np.sign(slopes[i] * slopes[j]))
        return inputs, r

    def claim(self, line: str, owner: str) -> None:
        """Note which result has a line of correlated inputs; raise CorrelationError if two do."""
        first = self.joint.setdefault(line, owner)
        if first != owner:
            raise CorrelationError(
                f"'{line}' is a line of {first} and of {owner}, and what they have in common of it"
                " is not known: write them as results of one equation"
            )

    def note_unsure(self, line: Component, name: str) -> None:
        """Note that it is unknown how much an input has in common with others."""
        if line.of_points:
            self.unsure[name] = line.of_points, True
        elif not line.shared:
            self.unsure[name] = line.name.partition(", of ")[0], False
        elif line.common and line.value == 0 and name != line.name:
            # An error that is stated as a share of the reading, and so of another size here.
            self.unsure |= dict.fromkeys((name, line.name), (line.name, False))

    def with_sharing(self, line: Component) -> Component:
        """Return a line of a result's budget, marked with what other results may share of it."""
        several_of, is_several, _ = line.name.partition(SEVERAL)
        source, is_scatter = self.unsure.get(line.name, ("", False))
        if is_several:
            source, is_scatter = several_of, (several_of, True) in self.unsure.values()
        return replace(
            line,
            shared=line.name not in self.unshared and (is_scatter or not is_several),
            at_place=line.name in self.at_place,
            of_points=source if is_scatter else "",
        )
