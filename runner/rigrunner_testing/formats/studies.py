"""Inputs of formats of reports on many runs: studies of generated values."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.studies import (
    CapabilitySeries,
    CapabilityStudy,
    Excluded,
    GaugeStudy,
    GoldenRun,
    GoldenStudy,
    Observed,
    Shift,
    Trend,
)
from rigrunner_fleet.trends.capability import capability
from rigrunner_fleet.trends.charting import Charting, control_chart
from rigrunner_fleet.trends.gauge_rr import gauge_rr
from rigrunner_testing.formats.inputs import MISCHIEF

if TYPE_CHECKING:
    from rigrunner.api.studies import StudyInput

_START = datetime(2026, 1, 1, tzinfo=UTC)
_RUNS = 30
_SHIFT = 6
"""The number of last values that are shifted, so that there are alarms."""


@lru_cache(maxsize=1)
def study_inputs() -> tuple[StudyInput, ...]:
    """Return charts of both kinds with alarms, a capability, a gauge study, and golden runs."""
    return (_trend("i-mr"), _trend("ewma"), _capability(), _gauge(), _golden())


def _golden() -> GoldenStudy:
    return GoldenStudy(
        quantity=MISCHIEF,
        unit="N·m",
        asked={"tolerance": MISCHIEF},
        excluded=(Excluded(MISCHIEF, MISCHIEF),),
        tolerance=0.1,
        counts=((MISCHIEF, True, 1), (MISCHIEF, False, 1)),
        flips=((MISCHIEF, MISCHIEF, 1),),
        shifts_in_u=(0.2, 0.0),
        set_points=(Shift(10.0, 2, 1e-3, None, 0.1, 0.2), Shift(20.0, 1, 1e-3, 1e-4, None, None)),
        runs=(GoldenRun(MISCHIEF, MISCHIEF, moved=True, verdict="", lines=(MISCHIEF,)),),
    )


def _observed() -> tuple[Observed, ...]:
    values = 0.7 + 0.01 * np.random.default_rng(1).normal(size=_RUNS)
    values[-_SHIFT:] += 0.05
    return tuple(
        Observed(f"{index} {MISCHIEF}", _START + timedelta(days=index), float(value), 0.009)
        for index, value in enumerate(values)
    )


def _trend(chart: str) -> Trend:
    charting = Charting(chart)
    return Trend(
        quantity=MISCHIEF,
        unit="N·m",
        asked={"lot": MISCHIEF},
        excluded=(Excluded(MISCHIEF, MISCHIEF),),
        chart=chart,
        rules=charting.rule_texts(),
        series=(control_chart(MISCHIEF, _observed(), charting),),
        not_charted={MISCHIEF: MISCHIEF},
    )


def _capability() -> CapabilityStudy:
    observed = _observed()
    indices = capability([value.value for value in observed], upper=0.95)
    return CapabilityStudy(
        quantity=MISCHIEF,
        unit="N·m",
        asked={"lot": MISCHIEF},
        lower=None,
        upper=0.95,
        series=(CapabilitySeries(MISCHIEF, observed, indices, (MISCHIEF,), None, 0.95),),
    )


def _gauge() -> GaugeStudy:
    rng = np.random.default_rng(2)
    readings = rng.normal(0.7, 0.05, (4, 1, 1)) + rng.normal(0.0, 0.005, (4, 2, 3))
    return GaugeStudy(
        quantity=MISCHIEF,
        unit="N·m",
        asked={"procedure": MISCHIEF},
        parts=tuple(f"{number} {MISCHIEF}" for number in range(4)),
        operators=("A", MISCHIEF),
        readings=tuple(tuple(tuple(map(float, cell)) for cell in part) for part in readings),
        analysis=gauge_rr(readings),
        tolerance=0.5,
        expanded=0.009,
    )
