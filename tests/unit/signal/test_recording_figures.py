"""Recordings and tables as figures."""

from __future__ import annotations

import numpy as np

from rigrunner.api.data import Measurement, Recording
from rigrunner.signal.recording_figures import MOST_CHANNELS, of_recording, of_table


def recording(channels, units=(), setpoints=()):
    started = "2026-01-01T00:00:00+00:00"
    return Recording("r", 10.0, started, dict(setpoints), channels, dict(units))


def test_decimation_keeps_every_peak():
    values = np.zeros(1_000_003)
    values[[123_457, 999_999]] = 5.0, -7.0
    figure = of_recording(recording({"a.b": values}, units={"a.b": "N"}))
    points = figure.panels[0].series[0].points
    assert len(points) <= 1500
    assert (min(p.y for p in points), max(p.y for p in points)) == (-7.0, 5.0)
    assert next(p.x for p in points if p.y == 5.0) == 12345.7
    assert figure.alt == "a.b: \N{MINUS SIGN}7 to 5 N"
    assert "equal stretches" in figure.caption


def test_caption_counts_channels_that_are_not_drawn():
    channels = {f"a.c{n}": np.arange(3.0) for n in range(MOST_CHANNELS + 2)}
    figure = of_recording(recording(channels, setpoints={"load.f": 2.0}))
    assert [panel.y.name for panel in figure.panels] == [f"a.c{n}" for n in range(MOST_CHANNELS)]
    assert figure.caption == "Recording r at load.f 2. 2 more channels are not drawn."


def row(at, value):
    units = {"load.i": "A", "m.v": "V"}
    return Measurement(
        name="t", utc="2026-01-01T00:00:00+00:00", setpoints={"load.i": at, "load.x": 1.0},
        values={"m.v": value}, units=units,
    )  # fmt: skip


def test_table_is_drawn_over_its_varied_set_point():
    figure = of_table([row(0.0, 5.0), row(1.0, 4.9)])
    assert [(p.x, p.y) for p in figure.panels[0].series[0].points] == [(0.0, 5.0), (1.0, 4.9)]
    assert str(figure.panels[0].x) == "set load.i / A"


def test_table_of_one_set_point_is_drawn_over_its_rows():
    figure = of_table([row(1.0, 5.0), row(1.0, 4.9)])
    assert [p.x for p in figure.panels[0].series[0].points] == [1.0, 2.0]
    assert of_table([row(1.0, 5.0)]) is None
