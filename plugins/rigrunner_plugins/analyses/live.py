"""The analysis `readings` during a recording: running statistics, block by block."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Estimate, Findings, MeasurementResult, unit
from rigrunner.api.data import place_of
from rigrunner.api.figures import Axis, Figure, Point, Series
from rigrunner.api.places import is_at

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import Array, Block, Recording, RunData
    from rigrunner.api.coordinates import CoordinateValue
    from rigrunner_plugins.analyses.settings import ReadingsSettings

MOST_POINTS = 400
"""Most points in the curve of a recording; above it, every other point is dropped."""


@dataclass
class Running:
    """Running mean, spread and extremes (Chan, Golub and LeVeque, 1983)."""

    count: int = 0
    mean: float = 0.0
    squares: float = 0.0
    """The sum of the squared deviations from the mean."""
    least: float = inf
    greatest: float = -inf

    def take(self, values: Array) -> None:
        """Add values, shape (n,), n at least 1."""
        n, mean = len(values), float(values.mean())
        total, shift = self.count + n, mean - self.mean
        self.squares += float(((values - mean) ** 2).sum()) + shift**2 * self.count * n / total
        self.mean += shift * n / total
        self.count = total
        self.least = min(self.least, float(values.min()))
        self.greatest = max(self.greatest, float(values.max()))

    def statistic(self, name: str) -> float:
        """Return a statistic; nan if it needs all values at once, or more values."""
        several = self.count > 1
        return {
            "mean": self.mean,
            "minimum": self.least,
            "maximum": self.greatest,
            "range": self.greatest - self.least,
            "rms": sqrt(self.squares / self.count + self.mean**2),
            "standard_deviation": sqrt(self.squares / (self.count - 1)) if several else nan,
        }.get(name, nan)


@dataclass
class LiveReadings:
    """Implements `rigrunner.api.findings.LiveAnalysis`. It stores a few numbers for each place."""

    settings: ReadingsSettings
    _at: dict[tuple[CoordinateValue, ...], tuple[Mapping[str, CoordinateValue], Running]] = field(
        default_factory=dict
    )
    _running: Running | None = None
    _curve: list[tuple[float, float]] = field(default_factory=list)
    _every: int = 1
    _blocks: int = 0

    def begin(self, recording: Recording, run: RunData) -> None:  # noqa: ARG002  (of any run)
        """Start a recording, if the procedure selects it.

        A value relative to a partner run is known only when the analysis is complete.
        """
        settings, place = self.settings, place_of(recording)
        self._running, self._curve, self._every, self._blocks = None, [], 1, 0
        selected = bool(recording.name) and settings.table is None and settings.compared is None
        selected = selected and all(name in recording.channels for name in settings.channels)
        if selected and is_at(settings.where, place) and place.keys() >= set(settings.per):
            at = {name: place[name] for name in settings.per}
            _, self._running = self._at.setdefault(tuple(at.values()), (at, Running()))

    def take(self, block: Block) -> tuple[()]:
        """Add the next block of the recording."""
        if self._running is None or not block.samples:
            return ()
        settings = self.settings
        values = np.asarray(block.channels[settings.of], float)
        if settings.minus is not None:
            values = values - block.channels[settings.minus]
        if settings.divided_by is not None:
            with np.errstate(divide="ignore", invalid="ignore"):  # what is not finite is not shown
                values = values / block.channels[settings.divided_by]
        self._running.take(values)
        end_s = (block.first_sample + block.samples) / block.rate_hz
        shown = self._shown(self._running)
        self._blocks += 1
        if self._blocks % self._every:
            return ()
        if np.isfinite(shown):
            self._curve.append((end_s, shown))
        if len(self._curve) > MOST_POINTS:
            # The later one of each pair stays, so that the curve still ends at the present value.
            self._curve, self._every = self._curve[1::2], 2 * self._every
        return ()

    def findings(self) -> Findings:
        """Return the present statistic at each place, and its curve over the recording."""
        (definition,) = self.settings.yields()
        values = [(place, running, self._shown(running)) for place, running in self._at.values()]
        results = tuple(
            MeasurementResult(
                of=definition,
                estimate=Estimate(value, nan, nan, definition.unit),
                coordinates=place,
                readings=running.count,
            )
            for place, running, value in values
            if np.isfinite(value)
        )
        points = tuple(Point(x, y) for x, y in self._curve)
        figure = Figure(
            title=f"{definition.words} so far",
            x=Axis("time", "s"),
            y=Axis(definition.symbol or definition.name, definition.unit),
            series=(Series("", points, "line"),),
            of=definition.name,
        )
        return Findings(results=results, figures=(figure,) if points else ())

    def _shown(self, running: Running) -> float:
        settings = self.settings
        unit_ = unit(settings.result.unit)
        value = running.statistic(settings.statistic) if running.count else nan
        return (value - (0.0 if settings.is_difference else unit_.offset)) / unit_.factor
