"""How a run ended, as the screen shows it."""

from __future__ import annotations

from math import nan
from pathlib import Path

import pytest

from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.data import Estimate
from rigrunner.api.errors import AbortedError
from rigrunner.api.events import Outcome
from rigrunner.api.findings import Findings, MeasurementResult, ResultDefinition
from rigrunner.run.finish import FinishedRun
from rigrunner_panel.view.result import finished_view, with_live, with_uncertainty
from rigrunner_panel.view.sections import ResultView


@pytest.mark.parametrize("unsafe", ["", "tester: load reads back 50 N, safe is 0 N"])
def test_unsafe_rig_is_shown_with_the_reason_of_the_end(unsafe):
    suffix = f"; the rig is not safe: {unsafe}" if unsafe else ""
    finished_run = FinishedRun(
        folder=Path("runs/one"),
        outcome=Outcome.ERROR if unsafe else Outcome.ABORTED,
        reason=f"stopped at the panel{suffix}",
        error=AbortedError("stopped at the panel", by="me"),
        unsafe=unsafe,
    )
    assert finished_view(finished_run).error == f"stopped at the panel{suffix}"


def test_live_value_of_more_readings_replaces_the_analysed_one():
    """Its U is not known yet, its limits stay; a value of fewer readings is left out."""
    of = ResultDefinition(name="voltage", text="output voltage", unit="V", per=("current",))

    def live(readings, place):
        where = {"current": CoordinateValue(place, "A")}
        return MeasurementResult(
            of=of, estimate=Estimate(5.0, nan, nan, "V"), coordinates=where, readings=readings
        )

    earlier = tuple(
        ResultView(name="voltage", text="output voltage", symbol="", unit="V", place=place,
                   value=4.0, U=0.1, readings=10, upper=6.0)
        for place in ("1 A", "2 A")
    )  # fmt: skip
    view = with_live(None, Findings()).model_copy(update={"results": earlier})
    view_now = with_live(view, Findings(results=(live(20, 1.0), live(5, 2.0), live(1, 3.0))))
    assert [(row.place, row.value, row.U, row.upper) for row in view_now.results] == [
        ("1 A", 5.0, None, 6.0), ("2 A", 4.0, 0.1, 6.0), ("3 A", 5.0, None, None),
    ]  # fmt: skip


def test_count_coordinate_shows_its_name():
    of = ResultDefinition(name="friction", text="friction", unit="N·m", per=("cycles", "phase"))
    where = {"cycles": CoordinateValue(505.0), "phase": CoordinateValue("wear")}
    result = MeasurementResult(
        of=of, estimate=Estimate(1.0, nan, nan, "N·m"), coordinates=where, readings=1
    )
    view = with_live(None, Findings(results=(result,)))
    assert [result.place for result in view.results] == ["cycles 505, wear"]


@pytest.mark.parametrize(
    ("value", "width", "text"),
    [
        (5.25e-6, nan, "5.25e-06 ± ?"),  # was 0.000005
        (98765.4, 1234.0, "98800 ± 1200"),
        (-0.001, 0.1, "0.00 ± 0.10"),
    ],
)
def test_value_is_rounded_to_its_uncertainty(value, width, text):
    assert with_uncertainty(value, width) == text
