"""Runs for the analysis `equation`, made of known numbers."""

from __future__ import annotations

from functools import cache

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.data import Measurement, RunData
from rigrunner.api.instruments import Instrument
from rigrunner.api.units import unit
from rigrunner.registry import load_registry

START = "2026-01-05T10:00:00+00:00"


def instrument(channel, measures, accuracy) -> Instrument:
    return Instrument.model_validate(
        {"channel": channel, "measures": measures, "serial": "M-1", "accuracy": accuracy}
    )


_registry = cache(load_registry)


def run_of(columns, units, instruments=(), places=None) -> RunData:
    """Return a run with a table of columns (SI values), each row at a place, in A."""
    count = len(next(iter(columns.values())))
    rows = tuple(
        Measurement(
            "measured",
            f"2026-01-05T10:{i // 60:02d}:{i % 60:02d}+00:00",
            {"load.current": (places or [0.0] * count)[i]},
            {name: float(values[i]) for name, values in columns.items()},
            {**units, "load.current": "A"},
        )
        for i in range(count)
    )
    return RunData(
        run_id="r", procedure_id="P", procedure_revision="A", procedure_title="", station_id="s",
        started_utc=START, ended_utc=START, outcome="completed", inputs={},
        instruments={meter.channel: meter for meter in instruments}, zeros={}, recordings=(),
        measurements=rows,
    )  # fmt: skip


def findings(settings, run):
    """Return the scrutinised findings of the analysis; its units must fit."""
    registry = _registry()
    units = {name: unit_ for row in run.measurements for name, unit_ in row.units.items()}
    assert not registry.objections("equation", settings, units)
    assert all(unit(unit_) for unit_ in units.values())
    return Scrutiny(registry).make("analysis", "equation", settings)(run)
