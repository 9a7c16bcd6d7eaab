"""The inputs of a measurement model at one place: from readings, the register, and other results.

A reading is `mean (1 + gain) + offset + ...`. The mean has the scatter of the readings (type A),
and each error in the register is an input of its own (type B). Errors of one instrument are the
same wherever its channel is used; channels read together keep their observed correlation.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Distribution, Input, MeasurementResult
from rigrunner.api.units import si_symbol
from rigrunner_plugins.analyses.equation.inputs import CorrelationError, Inputs
from rigrunner_plugins.analyses.equation.result_inputs import enter_result
from rigrunner_plugins.analyses.equation.tree import Effect
from rigrunner_plugins.analyses.settings import unit_of_errors
from rigrunner_plugins.analyses.sources import line_name
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
    inputs = Inputs()
    inputs.fixed |= {name: quantity.si for name, quantity in settings.parsed.literals.items()}
    _enter_readings(inputs, settings, group)
    errors = _enter_instruments(inputs, run, settings, group)
    for name, constant in settings.constants.items():
        if constant.standard_uncertainty:
            inputs.inputs.append(
                Input(
                    name,
                    constant.value.si,
                    constant.standard_uncertainty,
                    constant.dof,
                    Distribution(constant.shape),
                    si_symbol(constant.value.dimension),
                    common=True,
                )
            )
        else:
            inputs.fixed[name] = constant.value.si
    taken = {*settings.inputs, *settings.constants, *settings.parsed.literals}
    taken |= {equation.name for equation in settings.parsed.equations}
    for name, result in results.items():
        if isinstance(result, MeasurementResult):
            enter_result(inputs, name, result, taken, group.place)
        else:
            inputs.fixed[name] = nan
    for correlation in settings.correlations:
        one, other = correlation.between
        if one in settings.constants:
            inputs.r[one, other] = correlation.r
        else:
            pairs = dict.fromkeys(_pairs(errors[one], errors[other]), correlation.r)
            if correlation.r and not pairs:
                names = [
                    ", ".join(error.name for error in errors[name]) or "none"
                    for name in (one, other)
                ]
                raise CorrelationError(
                    f"{one} and {other} are to be correlated, and the register has no errors of one"
                    f" kind for both instruments (for {one}: {names[0]}; for {other}: {names[1]})"
                )
            inputs.r |= pairs
    _group_correlated(inputs)
    for line in set(inputs.joint) & set(inputs.lines.values()):
        inputs.claim(line, "the model")
    return inputs


def _enter_readings(inputs: Inputs, settings: EquationSettings, group: Group) -> None:
    """Add the mean of each channel, with its scatter and the observed correlations."""
    scattered: dict[str, tuple[float, float]] = {}
    for name, channel in settings.channels.items():
        values = group.values[channel.of]
        if channel.scatter is not None:
            dof = inf if channel.degrees_of_freedom is None else channel.degrees_of_freedom
            u = channel.scatter.si / sqrt(len(values))
            shape = Distribution.T if dof < inf else Distribution.NORMAL
            inputs.inputs.append(
                Input(name, float(values.mean()), u, dof, shape, group.units[channel.of])
            )
            continue
        scatter = mean_scatter(group.series(values))
        if scatter is None or scatter[0] == 0:
            inputs.fixed[name] = float(values.mean())
        else:
            scattered[name] = scatter
    together = len(scattered) > 1
    # Of one joint t distribution there is one number of degrees of freedom: the least.
    dof = min((dof for _, dof in scattered.values()), default=inf)
    for name, (u, own_dof) in scattered.items():
        source = settings.inputs[name].of
        mean = float(group.values[source].mean())
        inputs.inputs.append(
            Input(name, mean, u, dof if together else own_dof, Distribution.T, group.units[source],
                  ensemble=TOGETHER if together else "")
        )  # fmt: skip
    if together:
        names = list(scattered)
        r = correlation_of_means(
            [group.series(group.values[settings.inputs[name].of]) for name in names]
        )
        for i, name in enumerate(names):
            for j in range(i):
                # Rounding may leave a little more than 1.
                inputs.r[names[j], name] = float(np.clip(r[i, j], -1.0, 1.0))


def _enter_instruments(
    inputs: Inputs, run: RunData, settings: EquationSettings, group: Group
) -> dict[str, list[Input]]:
    """Add each error in the register, and of each zero; return the former by instrument."""
    register_errors: dict[str, Input] = {}
    zeros: dict[str, Input] = {}
    by_input: dict[str, list[Input]] = {}
    for name, channel in settings.channels.items():
        by_input[name], effects = [], list[Effect]()
        largest = float(np.abs(group.values[channel.of]).max())
        exact = channel.of in group.set_points and channel.of not in run.instruments
        errors = run.reading_errors(channel.of, largest) if channel.instrument and not exact else ()
        for error in errors:
            error_name = line_name(error)
            symbol = "1" if error.acts == "gain" else unit_of_errors(group.units[channel.of])
            register_error = register_errors.setdefault(
                error_name,
                Input(error_name, 0.0, error.u, error.dof, Distribution(error.distribution), symbol,
                      common=True),
            )  # fmt: skip
            by_input[name].append(register_error)
            effects.append(Effect(error_name, is_gain=error.acts == "gain"))
            if error.acts == "each":
                inputs.unshared.add(error_name)
                inputs.unsure[error_name] = error_name, False
        for error, mask in group.zero_errors(run, channel.of):
            symbol = unit_of_errors(group.units[channel.of])
            zeros[error.name] = Input(error.name, 0.0, error.u, error.dof,
                                      Distribution(error.distribution), symbol,
                                      common=True)  # fmt: skip
            effects.append(Effect(error.name, slope=float(mask.mean())))
        inputs.effects[name] = tuple(effects)
    inputs.inputs += [*register_errors.values(), *zeros.values()]
    return by_input


def _pairs(one: Sequence[Input], other: Sequence[Input]) -> Iterator[tuple[str, str]]:
    """Yield pairs of like errors of two instruments: gain with gain, and so on."""
    for a in one:
        for b in other:
            kinds = [error.name.partition(" of ")[0] for error in (a, b)]
            if a.name != b.name and kinds[0] == kinds[1] and a.dof == b.dof:
                yield a.name, b.name


def _group_correlated(inputs: Inputs) -> None:
    """Give correlated inputs one common budget line and common degrees of freedom."""
    groups: list[set[str]] = []
    for pair in inputs.r:
        joined = [group for group in groups if group & set(pair)]
        groups = [group for group in groups if group not in joined]
        groups.append(set(pair).union(*joined))
    for group in groups:
        members = [member for member in inputs.inputs if member.name in group]
        names = [member.name for member in members]
        line = f"{', '.join(names[:-1])} and {names[-1]}"
        scatter = members[0].ensemble == TOGETHER
        line = f"scatter of {line}, read together" if scatter else f"{line}, correlated"
        ensemble = members[0].ensemble or (line if members[0].dof < inf else "")
        for member in members:
            inputs.lines[member.name] = line
            place = inputs.inputs.index(member)
            inputs.inputs[place] = replace(member, line=line, ensemble=ensemble)
