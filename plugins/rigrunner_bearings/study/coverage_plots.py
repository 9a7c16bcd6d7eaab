"""The figures of a study of coverage as SVG: the same study gives the same bytes."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import style
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from rigrunner_bearings.study.coverage import BANDS_HZ, METHODS
from rigrunner_bearings.study.coverage_rigs import FREQUENCIES_HZ, RANGES
from rigrunner_bearings.study.coverage_table import WITH, WITHOUT, band_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner_bearings.study.coverage import Sample, Study

BLUE, VERMILION, GREY, INK = "#0072B2", "#D55E00", "#5F6B7A", "#1f2933"
"""Of the palette of Okabe and Ito (2008), distinguishable by most colour-blind readers."""
COLOURS = dict(zip(RANGES, (BLUE, VERMILION), strict=True))
STYLE = {
    "svg.hashsalt": "rigrunner",
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}
DODGE_HZ = 0.5
LEAST, MOST = 0.85, 1.0
"""Of coverage, where the colours end; 95 % is white."""
AIM = 0.95
WIDEST = 4.0
"""Of the histogram of error over u."""


def draw_figures(study: Study, folder: Path) -> list[Path]:
    """Write every figure into a folder, which is created; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, (paint, height_in) in FIGURES.items():
        path = folder / f"{name}.svg"
        with style.context(["default", STYLE]):
            figure = Figure(figsize=(8.4, height_in), layout="constrained")
            paint(figure, study)
            figure.savefig(path, format="svg", metadata={"Date": None})
        paths.append(path)
    return paths


def _errors(figure: Any, study: Study) -> None:
    """Paint the error over frequency: median, the middle 95 % as a bar, the extremes as dots."""
    all_axes = figure.subplots(1, len(METHODS), sharey=True)
    for axes, sample in zip(all_axes, _samples(study, sensor=True), strict=True):
        for place, (simulator, colour) in enumerate(COLOURS.items()):
            mask = np.array(sample.simulator) == simulator
            if mask.any():
                x = np.array(FREQUENCIES_HZ) + DODGE_HZ * (2 * place - 1)
                _bars(axes, x, 1000 * sample.error_nm[mask], colour, simulator)
        axes.axhline(0, color=INK, linewidth=0.7)
        axes.set(title=sample.method, xlabel="frequency / Hz")
        axes.grid(visible=True, color="#E1E6EB")
    all_axes[0].set_ylabel("error / mN·m")
    all_axes[0].legend(loc="upper left")


def _bars(axes: Any, x: Any, errors: Any, colour: str, label: str) -> None:
    low, middle, high = np.quantile(errors, [0.025, 0.5, 0.975], axis=0)
    axes.vlines(x, low, high, color=colour, linewidth=4, alpha=0.45)
    axes.plot(x, middle, "o", color=colour, markersize=4, label=label)
    for extreme in (errors.min(axis=0), errors.max(axis=0)):
        axes.plot(x, extreme, ".", color=colour, markersize=3)


def _strata(figure: Any, study: Study) -> None:
    """Paint the coverage of every stratum, in per cent, white at 95."""
    norm = TwoSlopeNorm(AIM, LEAST, MOST)
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (sensor, method) in zip(grid.flat, product((True, False), METHODS), strict=True):
        rates = _rates(study, method, sensor=sensor)
        axes.imshow(rates, norm=norm, cmap="RdBu", aspect="auto")
        for (i, j), rate in np.ndenumerate(rates):
            if np.isfinite(rate):
                dark = not LEAST + 0.03 < rate < MOST - 0.01
                axes.text(
                    j, i, f"{100 * rate:.0f}", ha="center", va="center",
                    color="white" if dark else INK,
                )  # fmt: skip
        axes.set_title(f"{method}, {WITH if sensor else WITHOUT}")
        axes.set_xticks(range(len(FREQUENCIES_HZ)), [f"{f:g}" for f in FREQUENCIES_HZ])
        axes.set_yticks(range(len(BANDS_HZ)), [band_text(band) for band in BANDS_HZ])
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
    for axes in grid[1]:
        axes.set_xlabel("frequency / Hz")
    for axes in grid[:, 0]:
        axes.set_ylabel("resonance / Hz")


def _rates(study: Study, method: str, *, sensor: bool) -> Any:
    """Return the coverage, shape (bands, frequencies); NaN without a rig."""
    rates_by_place = {
        (s.band_hz, s.frequency_hz): s.coverage.rate
        for s in study.strata
        if s.method == method and s.sensor is sensor
    }
    rates = [[rates_by_place.get((band, f), np.nan) for f in FREQUENCIES_HZ] for band in BANDS_HZ]
    return np.array(rates)


def _ratios(figure: Any, study: Study) -> None:
    """Paint error over u against the normal distribution that it should have."""
    all_axes = figure.subplots(1, len(METHODS), sharey=True)
    edges = np.linspace(-WIDEST, WIDEST, 41)
    x = np.linspace(-WIDEST, WIDEST, 201)
    looks: Sequence[Mapping[str, Any]] = (
        {"color": BLUE, "alpha": 0.35},
        {"edgecolor": VERMILION, "fill": False, "histtype": "step", "linewidth": 1.3},
    )
    for axes, method in zip(all_axes, METHODS, strict=True):
        for sensor, look in zip((True, False), looks, strict=True):
            (sample,) = (s for s in _samples(study, sensor=sensor) if s.method == method)
            ratio = np.clip(sample.error_nm / sample.u_nm, -WIDEST, WIDEST).ravel()
            axes.hist(ratio, edges, density=True, label=WITH if sensor else WITHOUT, **look)
        axes.plot(x, np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi), color=INK, label="normal")
        axes.set(title=method, xlabel="error / u")
    all_axes[0].set_ylabel("density")
    all_axes[0].legend(loc="upper left")


def _samples(study: Study, *, sensor: bool) -> Iterator[Sample]:
    return (sample for sample in study.samples if sample.sensor is sensor)


FIGURES: Mapping[str, tuple[Callable[[Any, Study], None], float]] = {
    "coverage-errors": (_errors, 3.2),
    "coverage-strata": (_strata, 4.4),
    "coverage-ratios": (_ratios, 2.8),
}
