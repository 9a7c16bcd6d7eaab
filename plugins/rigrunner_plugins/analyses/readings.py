"""The analysis `readings`: a statistic of readings with its uncertainty.

Type A comes from the values themselves (GUM 4.2); type B comes from the instrument's register entry
(GUM 4.3). An error that all readings share, a gain or an offset, is carried through the statistic.
An error stated as one figure may differ between readings: a difference of two readings then
contains it twice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isnan, nan
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Component, DataError, Estimate, Findings, MeasurementResult, unit
from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.findings import MissingResult
from rigrunner.api.member import channel_of
from rigrunner.signal.coverage import excess_kurtosis
from rigrunner.signal.uncertainty import combine
from rigrunner_plugins.analyses.partner import Partner, joint_budget
from rigrunner_plugins.analyses.settings import quotient, si_unit
from rigrunner_plugins.analyses.sources import error_line, groups, line_name
from rigrunner_plugins.analyses.statistics import (
    STATISTICS,
    percentile,
    settling_time,
    why_no_integral,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api import Array, RunData
    from rigrunner.api.accuracy import ReadingError
    from rigrunner_plugins.analyses.settings import ReadingsSettings
    from rigrunner_plugins.analyses.sources import Group
    from rigrunner_plugins.analyses.statistics import Statistic

SPECIMEN = "specimen"
"""The input that names the specimen."""
SMALL = 1e-6
"""Share of an error used to find its effect; at this size every statistic is linear."""

_SPREAD = ".peak_to_peak"
"""Statistics of spread, in which an offset cancels. In a root mean square an offset acts by
mean/rms, at most 1, which is the factor used."""
_WORDS = {"peak_to_peak": "peak to peak value", "rms": "root mean square"}


@dataclass(frozen=True)
class Readings:
    """Implements `rigrunner.api.findings.Analysis`."""

    settings: ReadingsSettings

    def __call__(self, run: RunData) -> Findings:
        """Return the statistic of each group, or why it has none; raise DataError for no groups."""
        settings = self.settings
        names = settings.channels
        place_groups = groups(
            run, names, per=settings.per, where=settings.where, table=settings.table
        )
        compared = settings.compared
        partner = None
        if compared is not None:
            partner_run = run.partners[compared.name]
            per, where = tuple(compared.per or ()), compared.where
            partner_groups = groups(partner_run, names, per=per, where=where, table=settings.table)
            partner = Partner(partner_run, partner_groups, per, partner_words(compared.name))
        notes = list(self._of_another_specimen(run))
        single_readings = [group for group in place_groups if len(group.times_s) == 1]
        article = "each" if len(single_readings) == len(place_groups) else "a"
        statistic = settings.of.removeprefix(channel_of(settings.of))[1:]
        extremes = settings.statistic in {"minimum", "maximum", "range"}
        if single_readings and statistic:
            notes.append(
                f"{settings.result.name}: {article} value"
                f" is the {_WORDS.get(statistic, statistic)} of a recording, of which no scatter is"
                " kept: its uncertainty is the instrument's alone."
            )
        elif single_readings and settings.statistic == "mean":
            notes.append(
                f"{settings.result.name}: {article} value"
                " is a single reading, which shows no scatter: its uncertainty is the"
                " instrument's alone."
            )
        if extremes:
            notes.append(
                f"{settings.result.name}: the {settings.statistic} is that of what was"
                " read; its uncertainty is the instrument's alone."
            )
        at_places = [self._evaluate(run, group, partner) for group in place_groups]
        results = tuple(result for result in at_places if isinstance(result, MeasurementResult))
        if any(isnan(line.u) for result in results for line in result.components):
            notes.append(
                f"{settings.result.name}: there are too few readings, or recordings that"
                " agree, to know the uncertainty of a"
                f" {settings.statistic.replace('_', ' ')}."
            )
        return Findings(
            results=results,
            missing=tuple(result for result in at_places if isinstance(result, MissingResult)),
            notes=tuple(notes),
        )

    def _of_another_specimen(self, run: RunData) -> Iterator[str]:
        """Yield a note if the subtracted run is of another specimen, as in a queue."""
        if self.settings.tare is None:
            return
        tare = run.partners[self.settings.tare.name]
        specimen, tare_specimen = (a_run.inputs.get(SPECIMEN) for a_run in (run, tare))
        if specimen and tare_specimen and specimen != tare_specimen:
            words = partner_words(self.settings.tare.name)
            yield (
                f"{self.settings.result.name}: the {words}, {tare.run_id}, is of specimen"
                f" {tare_specimen}, and this run of {specimen}."
            )

    def _evaluate(
        self, run: RunData, group: Group, partner: Partner | None
    ) -> MeasurementResult | MissingResult:
        (definition,) = self.settings.yields()
        if why := self._why_undefined(group, partner):
            return MissingResult(of=definition, coordinates=group.place, why=why)
        statistic, shown = self._statistic, unit(definition.unit)
        value = statistic.value(group.series(self._values(group)))
        si = "1" if self.settings.relative_to else self._si_unit(group)
        if unit(si).dimension != shown.dimension:
            raise DataError(
                f"{definition.name} is stated in {shown.symbol}, and the"
                f" {self.settings.statistic} is in {si}"
            )
        if partner is None:
            components = tuple(self._components(run, group, 1 / shown.factor, shown.symbol))
        else:
            value, components = self._compare(run, group, partner, value)
        u, dof = combine(components)
        if any(isnan(line.u) for line in components):
            u, dof = float("nan"), float("nan")
        kurtosis = excess_kurtosis(((line.u, line.distribution) for line in components), u)
        number = value if self.settings.is_difference else value - shown.offset
        estimate = Estimate(number / shown.factor, u, dof, shown.symbol, kurtosis)
        return MeasurementResult(
            of=definition,
            estimate=estimate,
            components=components,
            coordinates=group.place,
            readings=len(group.times_s),
        )

    def _compare(
        self, run: RunData, group: Group, partner: Partner, value: float
    ) -> tuple[float, tuple[Component, ...]]:
        """Return the difference to the partner run, or the quotient, with both budgets."""
        other = partner.group_at(group)
        base = self._statistic.value(other.series(self._values(other)))
        shown = unit(self.settings.result.unit)
        own_factor, partner_factor, comparison = 1.0, -1.0, value - base
        if self.settings.relative_to is not None:
            own_factor, partner_factor, comparison = 1 / base, -value / base**2, value / base
        lines = tuple(self._components(run, group, own_factor / shown.factor, shown.symbol))
        scale, suffixes = partner_factor / shown.factor, partner.line_suffixes(run, other)
        of_partner = [
            line
            if line.common or not scale
            else self._partner_scatter(line, partner, other, base, scale)
            for line in self._components(
                partner.run, other, scale, shown.symbol, suffixes, of_run=f", {partner.words}"
            )
        ]
        return comparison, tuple(joint_budget(lines, of_partner, partner.words))

    def _partner_scatter(
        self, scatter: Component, partner: Partner, group: Group, base: float, scale: float
    ) -> Component:
        """Return the scatter of a value of the partner run: one error of all results that use it.

        These are all results, those with the coordinates that it is chosen by, or one at each
        place.
        """
        at = ", ".join(f"{name} = {value}" for name, value in group.place.items())
        is_of_several = not partner.per or set(partner.per) != set(self.settings.per)
        series = group.series(self._values(group))
        return replace(
            scatter,
            name=f"{scatter.name} of {self.settings.of}"
            f"{f' at {at}' if at and is_of_several else ''}",
            common=is_of_several,
            at_place=not is_of_several,
            value=base,
            unit=self._si_unit(group),
            # as it was computed: other results know it by this number
            input_u=(self._statistic.scatter(series) or (nan,))[0],
            sensitivity=scale,
        )

    def _why_undefined(self, group: Group, partner: Partner | None) -> str:
        """Return why the statistic has no value at a place; '' where it has one."""
        settings, measured = self.settings, [group]
        if partner is not None:
            measured.append(partner.group_at(group))
        if settings.statistic == "integral":
            reasons = (why_no_integral(group.series(group.times_s)) for group in measured)
            if why := next(filter(None, reasons), ""):
                return why
        divisor = settings.divided_by
        if divisor is not None and not all(group.values[divisor].all() for group in measured):
            return f"{divisor} is 0, and nothing can be divided by it"
        if partner is None or settings.relative_to is None:
            return ""
        base = measured[-1].series(self._values(measured[-1]))
        if self._statistic.value(base):
            return ""
        return f"the value of the {partner.words} is 0, and nothing can be divided by it"

    @property
    def _statistic(self) -> Statistic:
        settings = self.settings
        if settings.percent is not None:
            return percentile(settings.percent)
        if settings.within is not None:
            return settling_time(settings.within.si)
        return STATISTICS[settings.statistic]

    def _si_unit(self, group: Group) -> str:
        value = group.units[self.settings.of]
        if self.settings.divided_by is not None:
            value = quotient(value, group.units[self.settings.divided_by])
        is_difference = self.settings.is_difference
        return si_unit(self.settings.statistic, value, is_difference=is_difference)

    def _values(self, group: Group, channel: str = "", shift: Array | float = 0.0) -> Array:
        """Return the values for the statistic, with those of one channel replaced."""
        values = {name: array + (shift if name == channel else 0.0) for name, array in
                  group.values.items()}  # fmt: skip
        values_of = values[self.settings.of]
        if self.settings.minus is not None:
            return values_of - values[self.settings.minus]
        if self.settings.divided_by is not None:
            return values_of / values[self.settings.divided_by]
        return values_of

    def _components(
        self,
        run: RunData,
        group: Group,
        scale: float,
        symbol: str,
        suffixes: Mapping[str, str] = MappingProxyType({}),
        *,
        of_run: str = "",
    ) -> Iterator[Component]:
        """Yield the budget lines of a group, scaled.

        `suffixes` are appended to those of a channel, and `of_run` to those that no other run has.
        """
        series = group.series(self._values(group))
        scatter = self._statistic.scatter(series)
        if scatter is not None:
            u, dof = scatter
            rectangular = self.settings.statistic == "settling_time"
            yield Component(
                name="time between samples" if rectangular else "scatter of the readings",
                u=u * abs(scale),
                dof=dof,
                distribution="rectangular" if rectangular else "t",
                common=False,
                unit=symbol,
                input_u=u * abs(scale),
                sensitivity=1.0,
            )
        for channel, values in group.values.items():
            for error in run.reading_errors(channel, float(np.abs(values).max())):
                name = line_name(error) + suffixes.get(channel, "")
                if error.acts == "each" and self.settings.statistic == "range":
                    # two errors, not a larger one: their sum has another shape, and another k
                    for end in ("highest", "lowest"):
                        at_end = f"{name}, {end} value"
                        yield self._component(error, at_end, channel, group, scale)
                else:
                    yield self._component(error, name, channel, group, scale)
            for error, affected in group.zero_errors(run, channel):
                name = error.name + of_run
                yield self._component(error, name, channel, group, scale, affected=affected)

    def _component(
        self,
        error: ReadingError,
        name: str,
        channel: str,
        group: Group,
        scale: float,
        *,
        affected: Array | float = 1.0,
    ) -> Component:
        effect = self._effect(error, channel, group, affected) * scale
        return error_line(error, name, effect, group.units[channel])

    def _effect(
        self, error: ReadingError, channel: str, group: Group, affected: Array | float
    ) -> float:
        """Return the change of the statistic caused by an error, per unit of its size.

        `affected` is 1 for the values that have it, and 0 for others.
        """
        unchanged = self._values(group)
        value = self._statistic.value
        if error.acts == "each":
            step = SMALL * (float(np.abs(group.values[channel]).max()) or 1.0)
            slopes = np.abs(self._values(group, channel, step) - unchanged) / step
            slopes *= 2 if channel.endswith(_SPREAD) else 1  # of the highest and the lowest sample
            return self._statistic.bound(group.series(unchanged), slopes)
        if self.settings.statistic == "settling_time":
            return 0.0
        if error.acts == "offset" and channel.endswith(_SPREAD):
            return 0.0
        if error.acts == "gain" and len(group.values) == 1:
            return value(group.series(unchanged))  # in proportion, whatever the statistic
        size = group.values[channel] if error.acts == "gain" else np.ones(len(unchanged)) * affected
        step = SMALL if error.acts == "gain" else SMALL * (float(np.abs(unchanged).max()) or 1.0)
        moved = self._values(group, channel, step * size)
        return (value(group.series(moved)) - value(group.series(unchanged))) / step
