"""A coupling that loosens on the simulated rig: the chart tells it before it hurts."""

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
    """Both runs of a day, and the result by that day's own no-load run."""

    recorded: RecordedBench
    result: dict

    @property
    def off_by_share_of_u(self) -> float:
        return off(self.result, self.recorded)


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


def off(result: dict, recorded: RecordedBench) -> float:
    """Return by what share of its U a result misses the truth."""
    found = result["headline"]["compensated"]
    return abs(found["value"] - recorded.truths_nm[0]) / found["expanded_uncertainty_95"]


@pytest.fixture(scope="module")
def days(tmp_path_factory):
    """The days, and the folder with the archive of their runs."""
    frequencies = [SOUND_HZ] * SOUND_DAYS
    frequencies += [SOUND_HZ * (1 - DAILY_LOSS * each) for each in range(1, LOOSENING_DAYS + 1)]
    made = [day(each, seed) for seed, each in enumerate(frequencies, 1)]
    runs = tmp_path_factory.mktemp("coupling") / "runs"
    for number, each in enumerate(made):
        store_run(runs, f"day-{number:02d}", each.result, started_utc=on_day(number))
    index_all(runs)
    return made, runs


@pytest.mark.parametrize("chart", ["i-mr", "ewma"])
def test_a_loosening_coupling_is_told_before_the_torque_leaves_its_uncertainty(days, chart):
    made, runs = days
    done = call("trend", "fn", "--runs", runs, "--baseline", SOUND_DAYS, "--chart", chart, "--json")
    assert done.code == 1, done.err
    (series,) = json.loads(done.out)["series"]
    alarms = [number for number, each in enumerate(series["points"]) if each["rules"]]
    assert alarms, "it is told"
    assert SOUND_DAYS <= alarms[0] < SOUND_DAYS + LOOSENING_DAYS, "after it began, not before"
    assert max(each.off_by_share_of_u for each in made[: alarms[0] + 1]) < 1.0


def test_it_would_have_hurt(days):
    """A no-load run of the first day no longer serves after 100 days."""
    made, _ = days
    later = day(LOOSE_HZ, 99, made[0].recorded.no_load)
    assert later.off_by_share_of_u > 2.0


def test_the_torque_itself_tells_nothing_meanwhile(days):
    _, runs = days
    shewhart = ("--rules", "shewhart", "--baseline", SOUND_DAYS)
    assert call("trend", "torque", "--runs", runs, *shewhart).code == 0
