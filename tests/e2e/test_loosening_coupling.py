"""A coupling that loosens on the simulated rig: the chart shows it before results suffer."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import pytest

from e2e.helpers_trends import index_all, on_day
from helpers_cli import call
from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.document import document
from rigrunner_bearings.study.bench import Bench, Value
from rigrunner_bearings.study.recording import RecordedBench, record_bench
from rigrunner_bearings.study.tools import analysis_ref, primary_alone, tools
from unit.rigrunner_fleet.archive.helpers_archive import store_run

if TYPE_CHECKING:
    from rigrunner.api.data import RunData

pytestmark = pytest.mark.thorough


SOUND_HZ = 400.0
SOUND_DAYS = 12
DAILY_LOSS = 0.001
LOOSENING_DAYS = 6
LOOSE_HZ = 376.0


@dataclass(frozen=True)
class Day:
    """Both runs of a day, and the result with that day's no-load run."""

    recorded: RecordedBench
    result: dict

    @property
    def error_share_of_u(self) -> float:
        return error_share(self.result, self.recorded)


def day(natural_hz: float, seed: int, no_load: RunData | None = None) -> Day:
    rig = {"drive_line.natural_frequency": Value(natural_hz, "Hz")}
    bench = Bench(
        simulator="swing_tester_sim", seed=seed, frequencies_hz=(8.0, 15.0, 25.0, 35.0), cycles=6,
        no_load=rig, loaded=rig, reference_hz=SOUND_HZ, pause_s=600.0,
    )  # fmt: skip
    shared = tools()
    recorded = record_bench(bench, shared.registry, shared.measured_station)
    result = analyse(
        replace(recorded.loaded, partners={"no_load": no_load or recorded.no_load}),
        (analysis_ref(primary_alone(shared.spec)),),
        acceptance=None,
        measurand=shared.measurand,
        lookup=shared.registry,
    )
    return Day(recorded, document(result))


def error_share(result: dict, recorded: RecordedBench) -> float:
    """Return the error of a result as a share of its U."""
    estimate = result["headline"]["compensated"]
    return abs(estimate["value"] - recorded.truths_nm[0]) / estimate["expanded_uncertainty_95"]


@pytest.fixture(scope="module")
def days(tmp_path_factory):
    """Return the days, and the folder with the archive of their runs."""
    frequencies = [SOUND_HZ] * SOUND_DAYS
    frequencies += [
        SOUND_HZ * (1 - DAILY_LOSS * lost_days) for lost_days in range(1, LOOSENING_DAYS + 1)
    ]
    made = [day(natural_hz, seed) for seed, natural_hz in enumerate(frequencies, 1)]
    runs = tmp_path_factory.mktemp("coupling") / "runs"
    for number, single_day in enumerate(made):
        store_run(runs, f"day-{number:02d}", single_day.result, started_utc=on_day(number))
    index_all(runs)
    return made, runs


@pytest.mark.parametrize("chart", ["i-mr", "ewma"])
def test_chart_shows_a_loosening_coupling_in_time(days, chart):
    made, runs = days
    done = call("trend", "fn", "--runs", runs, "--baseline", SOUND_DAYS, "--chart", chart, "--json")
    assert done.code == 1, done.err
    (series,) = json.loads(done.out)["series"]
    alarms = [number for number, point in enumerate(series["points"]) if point["rules"]]
    assert alarms, "the chart raises an alarm"
    assert SOUND_DAYS <= alarms[0] < SOUND_DAYS + LOOSENING_DAYS, "after it began, not before"
    assert max(single_day.error_share_of_u for single_day in made[: alarms[0] + 1]) < 1.0


def test_old_no_load_run_gives_a_wrong_result(days):
    """A no-load run of the first day is no longer valid after 100 days."""
    made, _ = days
    later = day(LOOSE_HZ, 99, made[0].recorded.no_load)
    assert later.error_share_of_u > 2.0


def test_chart_of_the_torque_shows_nothing(days):
    _, runs = days
    shewhart = ("--rules", "shewhart", "--baseline", SOUND_DAYS)
    assert call("trend", "torque", "--runs", runs, *shewhart).code == 0
