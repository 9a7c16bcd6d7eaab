"""The columns of an importer are checked before they are used as samples."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rigrunner.api.errors import PluginError
from rigrunner.api.importing import Column
from rigrunner.tools.importing.columns import MappedColumn, read_part

TORQUE = "tester.torque"
GOOD = np.arange(10.0)


def _read(answer):
    """Return the part that is read from an importer's answer for one channel, at 1 kHz."""
    spec = SimpleNamespace(column="T", unit="mN·m", file_says="")
    mapping = SimpleNamespace(
        model=SimpleNamespace(
            sampling=SimpleNamespace(time=None, rate=1000.0),
            format=SimpleNamespace(name="strange"),
        ),
        file=Path,
    )
    part = SimpleNamespace(file="a.txt", group="", from_=None, to=None)
    importer = SimpleNamespace(read=lambda *_: answer)
    mapped = {TORQUE: MappedColumn(spec, ("columns", TORQUE))}
    return read_part(mapping, importer, part, ("recordings", 0), mapped)


@pytest.mark.parametrize("values", [GOOD, GOOD.astype(int), GOOD.astype(">f4"), list(GOOD)])
def test_real_numbers_become_float64_in_si(values):
    (values_si,) = _read({TORQUE: Column(values)}).columns.values()
    assert values_si.dtype == np.dtype("<f8")
    assert np.array_equal(values_si, GOOD * 1e-3)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (None, "NoneType, expected a Column for each name"),
        ({}, "None for 'tester.torque', expected a Column"),
        ({TORQUE: GOOD}, "expected a Column"),
        ({TORQUE: Column(GOOD + 1j)}, "values that are complex128"),
        ({TORQUE: Column(np.ma.array(GOOD, mask=GOOD > 5))}, "values that are masked"),
        ({TORQUE: Column(GOOD.astype(str))}, "values that are <U32"),
        ({TORQUE: Column(GOOD.astype("timedelta64[s]"))}, "values that are timedelta64[s]"),
        ({TORQUE: Column(GOOD * np.nan)}, "not a row of finite numbers"),
        ({TORQUE: Column(GOOD.reshape(5, 2))}, "not a row of finite numbers"),
        ({TORQUE: Column(GOOD, interval_s=float("nan"))}, "an interval of nan s"),
        ({TORQUE: Column(GOOD, interval_s="1 ms")}, "an interval of '1 ms' s"),
        ({TORQUE: Column(GOOD, interval_s=0.0)}, "an interval of 0.0 s"),
    ],
)
def test_invalid_column_is_an_error_of_the_importer(answer, message):
    with pytest.raises(PluginError, match="the importer 'strange' gave") as caught:
        _read(answer)
    assert message in caught.value.message
