"""Plots of arrays."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import matplotlib as mpl
import numpy as np
import pytest

from rigrunner.api.errors import UsageError
from rigrunner.plots import samples, torque_over_frequency
from rigrunner.plots.samples import extremes

pytestmark = pytest.mark.figures


def test_of_many_samples_no_peak_is_lost():
    values = np.zeros(1_000_003)
    values[[123_457, 999_999]] = 5.0, -7.0
    places, shown = extremes(values)
    assert len(places) <= 4000
    assert shown.max() == 5.0
    assert shown.min() == -7.0
    assert places[shown.argmax()] == 123_457
    assert (np.diff(places) >= 0).all()


def test_of_few_samples_each_is_drawn():
    places, shown = extremes(np.array([1.0, 2.0, 3.0]))
    assert (list(places), list(shown)) == ([0.0, 1.0, 2.0], [1.0, 2.0, 3.0])


def test_a_plot_is_shown_by_a_notebook_and_saved(tmp_path):
    plot = torque_over_frequency(
        np.array([1.0, 2.0]),
        np.array([2.0, 3.0]),
        np.array([0.7, np.nan]),
        np.array([np.nan, np.nan]),
        title="$a$ & <b>",
        limits_nm=[0.95],
    )
    assert ET.fromstring(plot._repr_svg_()).tag.endswith("svg")  # noqa: S314  (our own figure)
    for name in ("a.svg", "a.png", "a.pdf"):
        plot.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000
    with pytest.raises(UsageError, match="cannot be written"):
        plot.save(tmp_path / "a.nothing")


def test_drawing_leaves_the_style_of_others_as_it_was():
    before = dict(mpl.rcParams)
    samples(10.0, {"a": np.arange(3.0)}, {"a": "N·m"})
    assert dict(mpl.rcParams) == before
