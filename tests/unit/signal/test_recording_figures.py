"""What was recorded, as figures."""

from __future__ import annotations

import numpy as np

from rigrunner.api.data import Measurement, Recording
from rigrunner.signal.recording_figures import MOST_CHANNELS, of_recording, of_table


def recording(channels, units=(), setpoints=()):
    started = "2026-01-01T00:00:00+00:00"
    return Recording("r", 10.0, started, dict(setpoints), channels, dict(units))


def test_of_many_samples_no_peak_is_lost():
    values = np.zeros(1_000_003)
    values[[123_457, 999_999]] = 5.0, -7.0
    shown = of_recording(recording({"a.b": values}, units={"a.b": "N"}))
    points = shown.panels[0].series[0].points
    assert len(points) <= 1500
    assert (min(p.y for p in points), max(p.y for p in points)) == (-7.0, 5.0)
    assert next(p.x for p in points if p.y == 5.0) == 12345.7
    assert shown.alt == "a.b: \N{MINUS SIGN}7 to 5 N"
    assert "equal stretches" in shown.caption


def test_each_channel_has_its_panel_and_the_caption_counts_the_others():
    channels = {f"a.c{n}": np.arange(3.0) for n in range(MOST_CHANNELS + 2)}
    shown = of_recording(recording(channels, setpoints={"load.f": 2.0}))
    assert [panel.y.name for panel in shown.panels] == [f"a.c{n}" for n in range(MOST_CHANNELS)]
    assert shown.caption == "Recording r at load.f 2. 2 more channels are not drawn."


def row(at, value):
    units = {"load.i": "A", "m.v": "V"}
    return Measurement(
        name="t", utc="2026-01-01T00:00:00+00:00", setpoints={"load.i": at, "load.x": 1.0},
        values={"m.v": value}, units=units,
    )  # fmt: skip


def test_a_table_is_over_what_was_set_to_several_values():
    shown = of_table([row(0.0, 5.0), row(1.0, 4.9)])
    assert [(p.x, p.y) for p in shown.panels[0].series[0].points] == [(0.0, 5.0), (1.0, 4.9)]
    assert str(shown.panels[0].x) == "set load.i / A"


def test_a_table_of_one_set_point_is_over_its_rows():
    shown = of_table([row(1.0, 5.0), row(1.0, 4.9)])
    assert [p.x for p in shown.panels[0].series[0].points] == [1.0, 2.0]
    assert of_table([row(1.0, 5.0)]) is None
