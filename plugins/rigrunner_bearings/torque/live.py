"""The torque of swings during a recording: each swing as a curve, and the value of the latest."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Findings
from rigrunner.api.analysis.requirements import LEAST_CYCLES
from rigrunner.api.figures import Axis, Curve, Figure, Point, Series
from rigrunner.signal.coverage import expanded
from rigrunner_bearings.signal.swing_cutter import PHASES, SwingCutter
from rigrunner_bearings.torque.analysis import TorqueAnalysis
from rigrunner_bearings.torque.channels import motion_channel, set_frequency, torque_channel
from rigrunner_bearings.torque.prepare import prepare_point

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api import (
        AnalysisContext,
        Array,
        Block,
        MeasurementResult,
        OutlierRule,
        Recording,
        RunData,
    )
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.signal.swing_cutter import Swing
    from rigrunner_bearings.torque.settings import TorqueSettings

KEPT_CYCLES = LEAST_CYCLES + 5
"""Cycles of the latest samples to analyse, at least: as few still show a gross error."""
KEPT_SAMPLES = 200_000
"""Number of the latest samples to analyse, at least; a shorter recording is analysed as a whole."""
MOST_SAMPLES = 12_000_000
"""Of the latest samples, at most: a slower swing has a value once its recording has ended."""
SEEN = 10_000
"""Samples that the checks see of a recording that was prepared before."""
TURN_DEG = 360.0


class LiveTorque:
    """Implements `rigrunner.api.findings.SnapshotAnalysis` by the analysis of the stored run.

    A long recording is analysed by its latest whole cycles. No more of its samples is kept, and of
    a finished one only what was prepared. What takes long is done where the findings are made.
    """

    def __init__(self, settings: TorqueSettings, context: AnalysisContext) -> None:
        interim = replace(context, interim=True)
        self._analysis = TorqueAnalysis(settings, interim, prepare=self._prepare)
        self._prepared: dict[Recording, PeakPoint] = {}
        self._complete: dict[Recording, Recording] = {}
        self._partners: dict[str, RunData] | None = None
        self._earlier: tuple[Recording, ...] = ()
        self._points: dict[str, _FigurePoint] = {}
        self._results: tuple[MeasurementResult, ...] = ()
        self._current: _Latest | None = None
        self._finished: tuple[_Latest, ...] = ()
        """Recordings that have to be prepared before the next findings."""

    def begin(self, recording: Recording, run: RunData) -> None:
        """Start a recording; one without swings is left out."""
        if self._current is not None and self._current.recording.name:
            self._finished = (*self._finished, self._current)
        self._current = None
        with suppress(DataError):
            self._current = _Latest(recording, run, torque_channel(recording, run.instruments))

    def take(self, block: Block) -> Sequence[Curve]:
        """Take the next block; return the swings that it completes."""
        if self._current is None or not block.samples:
            return ()
        return [self._current.curve(swing) for swing in self._current.take(block)]

    def findings(self) -> Findings:
        """Return the torque at each set-point, and its figure."""
        return self.snapshot()()

    def snapshot(self) -> Callable[[], Findings]:
        """Return a function that makes these findings of the samples so far."""
        current, finished, window = self._current, self._finished, None
        self._finished = ()
        if current is not None and current.is_new and current.recording.name:
            current.is_new = False
            window = current.window()
        return partial(self._findings, finished, current, window)

    def _findings(
        self, finished: Sequence[_Latest], current: _Latest | None, window: Recording | None
    ) -> Findings:
        for samples in finished:
            self._finish(samples)
        if current is not None and window is not None:
            with suppress(DataError):  # too few cycles so far, or another kind of recording
                self._analyse(current, window)
            self._prepared.pop(window, None)
        points = [point for point in self._points.values() if point.frequency_hz > 0]
        figures = _figures(sorted(points, key=lambda point: point.frequency_hz))
        return Findings(results=self._results, figures=figures)

    def _analyse(self, current: _Latest, window: Recording) -> None:
        point = self._prepare_latest(current, window)
        self._points[window.name] = _FigurePoint(point)
        spec = self._analysis.spec
        is_missing = spec.no_load is not None and not (current.run.partners or spec.has_own_no_load)
        if is_missing or not spec.compensations:
            return
        if self._partners is None:
            self._partners = {}
            for name, partner in current.run.partners.items():
                # Their beginnings alone: the checks would read all of their recordings.
                beginnings = tuple(map(_beginning, partner.recordings))
                self._complete |= dict(zip(beginnings, partner.recordings, strict=True))
                self._partners[name] = replace(partner, recordings=beginnings)
        recordings = (*self._earlier, window)
        run = replace(current.run, recordings=recordings, partners=self._partners)
        findings = self._analysis(run)
        self._results = findings.results
        for point, compensated in self._analysis.compensated(findings):
            self._points[point.recording] = _FigurePoint(point, compensated)
            if point.recording == window.name:
                current.correct(compensated)

    def _prepare_latest(self, samples: _Latest, window: Recording) -> PeakPoint:
        point = self._analysis.prepared(window, samples.plain_run)
        self._prepared[window] = point
        return point

    def _finish(self, samples: _Latest) -> None:
        """Keep of a finished recording its point, and what the checks see of its samples."""
        window = samples.window()
        with suppress(DataError):
            point = self._prepare_latest(samples, window)
            del self._prepared[window]
            beginning = _beginning(window)
            self._prepared[beginning] = point
            self._earlier = (*self._earlier, beginning)

    def _prepare(
        self, recording: Recording, run: RunData, spec: TorqueSettings, rule: OutlierRule
    ) -> PeakPoint:
        """Return a recording prepared, each but once; raise DataError."""
        point = self._prepared.get(recording)
        if point is None:
            complete = self._complete.get(recording, recording)
            point = prepare_point(complete, run, spec, rule)
            if complete is not recording:
                self._prepared[recording] = point
        return point


@dataclass(frozen=True, eq=False)
class _FigurePoint:
    """A point of the figure."""

    point: PeakPoint
    compensated: CompensatedPoint | None = None

    @property
    def frequency_hz(self) -> float:
        return self.point.frequency_hz.value


class _Latest:
    """The latest samples of one recording, and the swings that they complete."""

    def __init__(self, recording: Recording, run: RunData, torque: str) -> None:
        """Raise DataError where no frequency was set."""
        self.recording = recording
        self.run = run
        # Samples are read as they are: blocks have been corrected.
        self.plain_run = replace(run, zeros={}, recording_zeros={}, instruments={})
        _, motion = motion_channel(recording)
        set_hz = set_frequency(recording, torque)
        if not set_hz > 0:
            raise DataError(f"recording {recording.name} has no cycles: its frequency was set to 0")
        rate_hz = recording.rate_hz
        self._torque = torque
        is_angle = bool(motion) and recording.units.get(motion) == "rad"
        self._angle = motion if is_angle else ""
        wanted_samples = KEPT_CYCLES * rate_hz / set_hz
        self._kept_samples = min(max(wanted_samples, KEPT_SAMPLES), MOST_SAMPLES)
        self.is_new = False
        """Whether a block came since the findings were made."""
        self._blocks: deque[dict[str, Array]] = deque()
        self._samples = self._next = 0
        self._cutter_rates = rate_hz, set_hz
        self._cutter = SwingCutter(rate_hz, set_hz)
        self._names = [name for name in (motion, torque) if name]
        self._correction: Array | None = None

    def take(self, block: Block) -> list[Swing]:
        """Take the next block; after a gap it begins again."""
        if block.first_sample != self._next:
            self._blocks.clear()
            self._samples = 0
            self._cutter = SwingCutter(*self._cutter_rates, block.first_sample)
        self._next = block.first_sample + block.samples
        channels = {name: np.asarray(block.channels[name]) for name in self._names}
        self.is_new = True
        if self.recording.name:
            self._blocks.append(channels)
            self._samples += block.samples
        while self._blocks and self._samples - self._length_of_first >= self._kept_samples:
            self._samples -= self._length_of_first
            self._blocks.popleft()
        return self._cutter.take(channels[self._torque], channels.get(self._angle))

    @property
    def _length_of_first(self) -> int:
        return len(self._blocks[0][self._torque])

    def window(self) -> Recording:
        """Return the recording with its latest samples."""
        blocks = [dict.fromkeys(self._names, np.empty(0)), *self._blocks]
        channels = {name: np.concatenate([block[name] for block in blocks]) for name in self._names}
        return replace(self.recording, channels=channels)

    def correct(self, compensated: CompensatedPoint) -> None:
        """Subtract what a method subtracts from the swings that follow."""
        if compensated.trace is not None:
            correction = compensated.trace.raw_nm - compensated.trace.compensated_nm
            phases = np.arange(PHASES) * len(correction) / PHASES
            self._correction = np.interp(
                phases, np.arange(len(correction) + 1), np.append(correction, correction[0])
            )

    def curve(self, swing: Swing) -> Curve:
        """Return a swing as it is drawn."""
        series = {"measured": swing.torque_nm}
        if self._correction is not None:
            series["compensated"] = swing.torque_nm - self._correction
        return Curve(
            title="Torque over one swing",
            x=Axis("crank angle", "°", 0.0, TURN_DEG),
            y=Axis("torque", "N·m"),
            at=TURN_DEG * np.arange(PHASES) / (PHASES - 1),
            series=series,
            end_s=swing.end_s,
            frequency_hz=swing.frequency_hz,
        )


def _beginning(recording: Recording) -> Recording:
    channels = {name: np.asarray(samples[:SEEN]) for name, samples in recording.channels.items()}
    return replace(recording, channels=channels)


def _figures(figure_points: Sequence[_FigurePoint]) -> tuple[Figure, ...]:
    """Return the torque over the frequency, measured and compensated; none without a point."""
    if not figure_points:
        return ()
    measured = tuple(
        Point(shown.frequency_hz, float(shown.point.peak_nm[shown.point.peak_kept].mean()))
        for shown in figure_points
    )
    series = [Series("measured", measured)]
    compensated = [
        (shown.frequency_hz, shown.compensated.torque)
        for shown in figure_points
        if shown.compensated is not None
    ]
    if compensated:
        series.insert(
            0,
            Series.over(
                [hz for hz, _ in compensated],
                [torque.value for _, torque in compensated],
                "compensated",
                U=[expanded(torque) for _, torque in compensated],
            ),
        )
    x, y = Axis("frequency", "Hz"), Axis("torque", "N·m")
    return (Figure("Torque over frequency so far", x, y, tuple(series)),)
