"""The tabulated device: the values of a table at its set-points, and nothing in between."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigrunner.api.devices import DeviceContext, Streaming
from rigrunner.api.errors import DeviceRejectedError, PluginError
from rigrunner.clock import SimulatedClock
from rigrunner.registry import load_registry

ROWS = [
    {"load": "0 N", "frequency": "30 rpm", "torque": "0.83 N·m"},
    {"load": "1 kN", "frequency": "30 rpm", "torque": "880 mN·m"},
    {"load": "1 kN", "frequency": "10 Hz", "torque": "2.16 N·m"},
]


def tabulated(**changes):
    settings = {"title": "A table", "set_points": ["load", "frequency"], "rows": ROWS} | changes
    context = DeviceContext("tester", SimulatedClock(), Path())
    return load_registry().make("device", "tabulated", settings, context)


@pytest.fixture
def table():
    device = tabulated()
    device.connect(1.0)
    return device


def test_each_row_is_read_at_its_set_points_in_si_units(table):
    for load_n, frequency_hz, torque_nm in ((0, 0.5, 0.83), (1000, 0.5, 0.88), (1000, 10, 2.16)):
        table.set("load", load_n)
        table.set("frequency", frequency_hz)
        assert table.read(["torque"]) == {"torque": pytest.approx(torque_nm, rel=1e-15)}
    assert [(info.name, info.unit) for info in table.channels] == [("torque", "N·m")]
    assert not isinstance(table, Streaming)


def test_set_points_small_in_si_units_are_distinguished():
    rows = [{"wavelength": f"{nm} nm", "power": f"{nm} µW"} for nm in (400, 400.5, 401)]
    device = tabulated(set_points=["wavelength"], rows=rows)
    device.connect(1.0)
    for nm in (400, 400.5, 401):
        device.set("wavelength", nm * 1e-9)
        assert device.read(["power"]) == {"power": pytest.approx(nm * 1e-6)}


def test_missing_row_lists_the_rows_of_the_table(table):
    table.set("frequency", 10.0)
    with pytest.raises(DeviceRejectedError) as raised:
        table.read(["torque"])
    assert "no row for load 0 N, frequency 600 rpm" in str(raised.value)
    places = "load 0 N, frequency 30 rpm; load 1 kN, frequency 30 rpm; load 1 kN, frequency 10 Hz"
    assert raised.value.hint == f"it has rows for {places}"


def test_missing_row_of_a_long_table_lists_the_first_rows():
    rows = [{"load": f"{i} N", "frequency": "1 Hz", "torque": "1 N·m"} for i in range(1, 56)]
    device = tabulated(rows=rows)
    device.connect(1.0)
    with pytest.raises(DeviceRejectedError) as raised:
        device.read(["torque"])
    assert raised.value.hint.endswith("load 6 N, frequency 1 Hz; and 49 more")


def test_set_point_can_be_the_frequency_of_a_motion():
    drives = tabulated(cycle_frequency="frequency").drives
    assert [(info.name, info.sets_cycle_frequency) for info in drives] == [
        ("load", False),
        ("frequency", True),
    ]
    assert [(info.minimum, info.maximum) for info in drives] == [(0, 1000), (0, 10)]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"set_points": ["load", "speed"]},
            "'speed', which is not a column.*load, frequency, torque",
        ),
        ({"set_points": ["load", "frequency", "torque"]}, "no column is left to read"),
        ({"cycle_frequency": "torque"}, "'torque', which is not among set_points"),
        ({"rows": [*ROWS, ROWS[0]]}, "rows 1 and 4 have the same set-points"),
        (
            {
                "set_points": ["flow"],
                "cycle_frequency": "",
                "rows": [{"flow": "1 L/min", "level": "1 mm"}, {"flow": "60 L/h", "level": "2 mm"}],
            },
            "rows 1 and 2 have the same set-points",
        ),
        ({"rows": [*ROWS, {"load": "2 N"}]}, "row 4 has load; the first row has load, frequency"),
        (
            {"rows": [ROWS[0], ROWS[1] | {"torque": "2.2 N"}]},
            "row 2, torque: got '2.2 N', expected a torque",
        ),
        ({"rows": []}, "at least 1"),
        ({"rows": [ROWS[0] | {"torque": 0.83}]}, "not a number with a unit"),
    ],
)
def test_invalid_tables_are_refused(changes, words):
    with pytest.raises(PluginError, match=words):
        tabulated(**changes)


def test_safe_temperature_is_not_absolute_zero():
    rows = [{"bath": f"{celsius} °C", "resistance": "100 Ω"} for celsius in (-20, 50)]
    device = tabulated(set_points=["bath"], rows=rows)
    device.connect(1.0)
    assert [info.range_text for info in device.drives] == ["-20 to 50 °C"]
    assert device.make_safe() == {"bath": pytest.approx(253.15)}
    device.set("bath", 303.15)
    with pytest.raises(DeviceRejectedError, match=r"no row for bath 30 °C"):
        device.read(["resistance"])
