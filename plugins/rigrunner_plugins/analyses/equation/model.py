"""The inputs of a measurement model at one place: from readings, the register, and other results.

A reading is `mean (1 + gain) + offset + ...`. The mean has the scatter of the readings (type A),
and each error in the register is an input of its own (type B). Errors of one instrument are the
same wherever its channel is used; channels read together keep their observed correlation.
"""

from __future__ import annotations

from math import inf, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Distribution, Input, MeasurementResult
from rigrunner.api.units import si_symbol
from rigrunner_plugins.analyses.equation.inputs import CorrelationError, Inputs
from rigrunner_plugins.analyses.equation.result_inputs import enter_result
from rigrunner_plugins.analyses.equation.tree import Effect
from rigrunner_plugins.analyses.settings import unit_of_errors
from rigrunner_plugins.analyses.statistics import correlation_of_means, mean_scatter

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api import RunData
    from rigrunner.api.findings import ResultPlace
    from rigrunner_plugins.analyses.equation.settings import EquationSettings
    from rigrunner_plugins.analyses.sources import Group

TOGETHER = "readings"
"""The name of the ensemble of means that were read together."""


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
            enter_result(found, name, result, taken, group.place)
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
        found.claim(line, "the model")
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
