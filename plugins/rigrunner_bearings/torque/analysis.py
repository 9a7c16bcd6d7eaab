"""The torque of the recordings: prepared, compensated, checked and validated."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from rigrunner.api import DataError, Findings, Member
from rigrunner.api.checks import forbidden
from rigrunner.api.scrutiny import Subject
from rigrunner_bearings.api.compensations import Compensation, Sweep
from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.api.torque import FittedTorque
from rigrunner_bearings.signal.peaks import peak_points
from rigrunner_bearings.torque.binding import bind
from rigrunner_bearings.torque.bracketing import Bracket, RecordedPoint, bracket
from rigrunner_bearings.torque.calibrated_range import beyond_calibration
from rigrunner_bearings.torque.channels import role_of, torque_channel
from rigrunner_bearings.torque.definition import definitions, kind_of
from rigrunner_bearings.torque.diagnosis import PreparedRuns, diagnose
from rigrunner_bearings.torque.document import DocumentedTorque
from rigrunner_bearings.torque.headline import (
    budget_of_mean,
    compensated_mean,
    mean_torque,
    raw_peak_mean,
    torque_at,
    without_scatter,
)
from rigrunner_bearings.torque.phase import compensated
from rigrunner_bearings.torque.prepare import prepare_point
from rigrunner_bearings.torque.sampling import with_half_the_samples
from rigrunner_bearings.torque.scrutiny import ScrutinisedMethod
from rigrunner_bearings.torque.settings import NO_LOAD, NO_LOAD_AFTER
from rigrunner_bearings.torque.sources import chosen, of_this_run, require_one_label, sources
from rigrunner_bearings.torque.starts import prepare_starts
from rigrunner_bearings.torque.study import with_study
from rigrunner_bearings.torque.validation import validate

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api import (
        AnalysisContext,
        Curve,
        Estimate,
        Fit,
        Instrument,
        OutlierRule,
        Points,
        Recording,
        RunData,
    )
    from rigrunner.api.analysis_context import Plugins
    from rigrunner.api.plugin_refs import PluginRef
    from rigrunner_bearings.api.compensations import CompensatedPoint, CompensationMethod
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.rig import RigDescription
    from rigrunner_bearings.api.validation import Validation
    from rigrunner_bearings.torque.settings import TorqueSettings


class Prepare(Protocol):
    """Prepares one recording, as `prepare_point` does."""

    def __call__(
        self, recording: Recording, run: RunData, spec: TorqueSettings, rule: OutlierRule
    ) -> PeakPoint:
        """Return the prepared recording; raise DataError."""
        ...


@dataclass(frozen=True)
class TorqueAnalysis:
    """Analyses the torque of runs, as a procedure asks for it."""

    spec: TorqueSettings
    context: AnalysisContext
    prepare: Prepare = prepare_point
    """May remember what it prepared before."""

    def __call__(self, run: RunData) -> Findings:
        """Return what was found; raise DataError where a recording cannot be prepared at all."""
        return _TorqueOfRun(
            run=chosen(run, self.spec.where),
            no_load_run=run.partners.get(NO_LOAD),
            no_load_after=run.partners.get(NO_LOAD_AFTER),
            spec=self.spec,
            context=self.context,
            prepare=self.prepare,
        ).findings()

    def prepared(self, recording: Recording, run: RunData) -> PeakPoint:
        """Return one recording prepared; raise DataError."""
        return self.prepare(recording, run, self.spec, _outlier_rule(self.spec, self.context))

    def compensated(self, findings: Findings) -> Iterator[tuple[PeakPoint, CompensatedPoint]]:
        """Yield the points that it found, each as the primary method compensates it."""
        for details in findings.details:
            if isinstance(details, DocumentedTorque) and self.spec.primary:
                points = details.compensations[self.spec.primary].points
                yield from zip(details.loaded, points, strict=False)


@dataclass(frozen=True, kw_only=True)
class _TorqueOfRun:
    """The analysis of the torque of one run, as a procedure asks for it."""

    run: RunData
    """With those recordings and rows alone that the analysis is of."""
    no_load_run: RunData | None
    no_load_after: RunData | None
    spec: TorqueSettings
    context: AnalysisContext
    prepare: Prepare

    def findings(self) -> Findings:
        """Return what was found; raise DataError where a recording cannot be prepared at all."""
        loaded = self._points(self.run, self._loaded_sources())
        no_load = self._no_load()
        around = self._bracket(loaded, no_load)
        no_load = no_load if around is None else around.between
        compensations = {
            reference.label: self._compensation(reference, loaded, no_load, around)
            for reference in self.spec.compensations
        }
        primary = compensations.get(self.spec.primary, Compensation(self.context.measurand, ()))
        primary, checks = bind(
            primary,
            diagnose(
                PreparedRuns(
                    self.run,
                    self.no_load_run,
                    loaded,
                    no_load,
                    self._with_half_the_samples(loaded, no_load, primary),
                    self.no_load_after,
                ),
                primary,
                own_no_load=self.spec.has_own_no_load,
            ),
        )
        headline, problem = None, ""
        if self.spec.primary:
            compensations[self.spec.primary] = primary
            if primary.points:
                headline = compensated_mean(primary.points)
            else:
                why = primary.not_applicable or "it gave no points"
                problem = f"{self.spec.primary} is not applicable: {why}"
        raw = self._raw(loaded) if loaded else None
        why = forbidden((*checks, *primary.checks))
        if problem:
            why = f"There is no result to decide on: {problem}"
        findings, plugins = self._torque(loaded, primary, headline, raw), self.context.plugins
        details = DocumentedTorque(
            spec=self.spec,
            plugins=plugins,
            name=self.spec.name,
            loaded=loaded,
            no_load=no_load,
            fits=fitted(
                self.spec, self.context.plugins, no_load if self.spec.compensations else loaded
            ),
            compensations=compensations,
            primary=self.spec.primary,
            kind=kind_of(self.spec, plugins),
            headline=headline,
            headline_components=findings.means[0].components if findings.means else (),
            raw_headline=raw,
            validation=self._validation(loaded, no_load, compensations, headline),
            problem=problem,
            forbids=why or without_scatter(loaded, no_load, primary),
        )
        notes = [problem] if problem else []
        notes += [
            f"{out.channel} exceeded its calibrated range: {out.text} ({out.run_id})."
            for out in beyond_calibration(details, self.run, self.no_load_run)
        ]
        return replace(findings, checks=checks, notes=tuple(notes), details=(details,))

    def _loaded_sources(self) -> tuple[Recording, ...]:
        if self.spec.has_own_no_load:
            return of_this_run(self.run, loaded=True)
        return sources(self.run)

    def _no_load(self) -> tuple[PeakPoint, ...]:
        if self.spec.has_own_no_load:
            return self._points(self.run, of_this_run(self.run, loaded=False))
        if self.no_load_run is None:
            return ()
        return self._points(self.no_load_run, sources(self.no_load_run))

    def _bracket(
        self, loaded: tuple[PeakPoint, ...], no_load: tuple[PeakPoint, ...]
    ) -> Bracket | None:
        """Return what no-load points are around the loaded ones, if they are; raise DataError."""
        spec = self.spec.no_load
        if spec is None or self.spec.starts or not (loaded and no_load):
            return None
        under_load = tuple(map(RecordedPoint, self._loaded_sources(), loaded))
        if spec.is_this_run:
            unloaded = of_this_run(self.run, loaded=False)
            return bracket(under_load, tuple(map(RecordedPoint, unloaded, no_load)), spec.drift)
        if self.no_load_run is None or self.no_load_after is None:
            return None
        early, late = sources(self.no_load_run), sources(self.no_load_after)
        after = self._points(self.no_load_after, late)
        without_load = tuple(map(RecordedPoint, (*early, *late), (*no_load, *after)))
        around = bracket(under_load, without_load, spec.drift)
        if around is None:
            raise DataError(
                f"{self.no_load_run.run_id} and {self.no_load_after.run_id} are not before and"
                f" after {self.run.run_id} at any frequency, by their times",
                hint="name the no-load runs made before and after it",
            )
        return around

    def _points(self, run: RunData, recordings: Sequence[Recording]) -> tuple[PeakPoint, ...]:
        """Return the prepared sources; none where the procedure asks for no analysis."""
        if not (self.spec.fits or self.spec.compensations):
            return ()
        if not recordings:
            raise DataError(f"run {run.run_id} has no recordings to analyse")
        require_one_label(recordings)
        rule = _outlier_rule(self.spec, self.context)
        if self.spec.starts is not None:
            return prepare_starts(recordings, run, self.spec.starts, self.spec, rule)
        return tuple(self.prepare(recording, run, self.spec, rule) for recording in recordings)

    def _method(self, reference: PluginRef) -> CompensationMethod:
        subject = Subject("compensation", reference.name)
        method = self.context.plugins.make("compensation", reference.name, reference.settings)
        return ScrutinisedMethod(subject, method)

    def _compensation(
        self,
        reference: PluginRef,
        loaded: tuple[PeakPoint, ...],
        no_load: tuple[PeakPoint, ...],
        around: Bracket | None,
    ) -> Compensation:
        method = self._method(reference)
        try:
            compensation = compensated(method, self._sweep(loaded, no_load))
            if around is not None:
                early, late = (
                    compensated(method, self._sweep(loaded, side))
                    for side in (around.before, around.after)
                )
                compensation = around.widened(compensation, early, late)
        except DataError as error:
            return Compensation(self.context.measurand, (), not_applicable=str(error))
        compensation = with_study(compensation, rig_of(self.run).gauge_study)
        compensation, checks = bind(compensation, compensation.checks)
        return replace(compensation, checks=checks)

    def _with_half_the_samples(
        self, loaded: tuple[PeakPoint, ...], no_load: tuple[PeakPoint, ...], primary: Compensation
    ) -> tuple[float, ...]:
        plugin = self.spec.primary_plugin
        if plugin is None or not primary.points:
            return ()
        method = self._method(plugin)
        return with_half_the_samples(method, self._sweep(loaded, no_load), primary)

    def _sweep(self, loaded: tuple[PeakPoint, ...], no_load: tuple[PeakPoint, ...]) -> Sweep:
        instrument = self._instrument()
        rig = with_known_load(self.run, instrument.channel, [point.load_n for point in loaded])
        apart = not self.spec.has_own_no_load and self.no_load_after is None
        return Sweep(
            loaded, no_load, rig, instrument, first_fit(self.spec, self.context.plugins), apart
        )

    def _validation(
        self,
        loaded: tuple[PeakPoint, ...],
        no_load: tuple[PeakPoint, ...],
        compensations: Mapping[str, Compensation],
        headline: Estimate | None,
    ) -> Validation | None:
        """Return the Monte Carlo check of the primary method, where one is asked for."""
        if self.spec.validate_ is None or headline is None or self.context.interim:
            return None
        primary = self.spec.primary
        (reference,) = (each for each in self.spec.compensations if each.label == primary)
        return validate(
            self._method(reference),
            self._sweep(loaded, no_load),
            compensations[primary].points,
            headline,
            name=primary,
            spec=self.spec.validate_.monte_carlo,
            zeroed=self._instrument().channel in self.run.zeros,
            progress=self.context.progress,
        )

    def _instrument(self) -> Instrument:
        channel = torque_channel(sources(self.run)[0], self.run.instruments)
        if channel not in self.run.instruments:
            raise DataError(
                f"the register of instruments has no {channel}",
                hint="enter its accuracy under instruments: in the station",
            )
        return self.run.instruments[channel]

    def _torque(
        self,
        loaded: tuple[PeakPoint, ...],
        primary: Compensation,
        mean: Estimate | None,
        raw: Estimate | None,
    ) -> Findings:
        """Return the compensated torque as results by its name; none where there is none."""
        definition = next(iter(definitions(self.spec, self.context)), None)
        if definition is None or mean is None:
            return Findings()
        lines = budget_of_mean(primary.points)
        return Findings(
            results=tuple(torque_at(definition, self.run, loaded, primary.points, self._raw)),
            means=(mean_torque(definition, loaded, mean, lines, raw),),
        )

    def _raw(self, points: Sequence[PeakPoint]) -> Estimate | None:
        """Return the mean of raw peaks; None where the register does not know their sensor."""
        try:
            instrument = self._instrument()
        except DataError:
            return None
        zeroed = instrument.channel in self.run.zeros
        return raw_peak_mean(points, instrument, zeroed=zeroed)


def _outlier_rule(spec: TorqueSettings, context: AnalysisContext) -> OutlierRule:
    if spec.outliers is None:
        return lambda _: []
    rule: OutlierRule = context.plugins.make(
        "outlier_rule", spec.outliers.name, spec.outliers.settings
    )
    return rule


def fitted(
    spec: TorqueSettings, plugins: Plugins, points: tuple[PeakPoint, ...]
) -> tuple[FittedTorque, ...]:
    """Return every fit of the procedure through the peaks; one that failed says why."""
    peaks = peak_points(points)
    return tuple(
        _fitted(reference.label, plugins.make("fit", reference.name, reference.settings), peaks)
        for reference in spec.fits
    )


def first_fit(spec: TorqueSettings, plugins: Plugins) -> Fit:
    """Return the fit that compensations take; without any, one that raises DataError."""
    if not spec.fits:
        return _no_fit
    first = spec.fits[0]
    return plugins.make("fit", first.name, first.settings)  # type: ignore[no-any-return]  # a fit


def _fitted(name: str, fit: Fit, points: Points) -> FittedTorque:
    try:
        return FittedTorque(name, points, fit(points))
    except DataError as error:
        return FittedTorque(name, points, None, problem=str(error))


def _no_fit(points: Points) -> Curve:  # noqa: ARG001  (a fit takes points)
    raise DataError("the procedure names no fit", hint="add one under analysis: fits:")


def with_known_load(run: RunData, torque: str, loads_n: Iterable[float]) -> RigDescription:
    """Return the run's rig with the load's relative limit of error at the least of its loads.

    That of the instrument for the load of the device that has the torque channel; as the station
    states it where the register has none, or does not say how accurate it is.
    """
    least = min((load for load in loads_n if load > 0), default=0.0)
    channel = Member(role_of(torque), "load")
    cell = run.instruments.get(channel)
    limit = None if cell is None or least == 0 else cell.limit_of_error(least)
    if limit is None:
        return rig_of(run)
    return rig_of(run).model_copy(update={"load_tolerance": limit / least})
