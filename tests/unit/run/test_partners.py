from datetime import timedelta

import pytest

from helpers_tester import both, procedure_file, run, station_file
from helpers_workflow import START
from rigrunner.api.errors import DataError, UsageError
from rigrunner.clock import SimulatedClock

pytestmark = pytest.mark.usefixtures("tester")
OWN = "same: [station], per: tester.frequency}\n      per: tester.frequency"
PLACES = ("same: [station]}", OWN), ("{of: torque, max", "{of: torque, each: tester.frequency, max")
"""Each frequency has its own tare."""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished")
    return folder, *both(folder)


@pytest.fixture
def loaded_run(finished, tmp_path):
    """Run `loaded` against the runs of `finished`, with changes."""
    folder, _, _ = finished

    def start(*changes, station=(), **options):
        procedure = procedure_file(tmp_path, "loaded", *changes)
        station_path = station_file(tmp_path, *station) if station else None
        return run(procedure, folder / "runs", station=station_path, **options)

    return start


def test_latest_fitting_idle_run_is_used(finished):
    _, idle, loaded = finished
    assert loaded.result.run.partners["tare"].run_id == idle.folder.name


@pytest.mark.parametrize(
    ("changes", "station", "message"),
    [
        ((), [("id: bench", "id: rig-7")], "its station is 'bench', but 'rig-7'"),
        ([*PLACES, ("[8 Hz, 15 Hz,", "[8 Hz, 12 Hz,")], (), "12 Hz"),
        ([("procedure: T-IDLE", "procedure: T-XYZ")], (), "a completed run of T-XYZ"),
    ],
)
def test_mismatching_idle_run_is_refused_before_the_run(loaded_run, changes, station, message):
    with pytest.raises(DataError, match=message) as caught:
        loaded_run(*changes, station=station)
    assert "run that procedure first, or name a run with --partner tare=RUN" in caught.value.hint


def test_old_idle_run_is_refused(loaded_run):
    """From the previous shift: a support that was at rest overnight has another friction."""
    message = r"it is 9 h old, but at most 8 h is allowed \(max_age, .*yaml:\d+:\d+\)"
    with pytest.raises(DataError, match=message):
        loaded_run(clock=SimulatedClock(START + timedelta(hours=9)))


def test_later_idle_run_is_not_used_automatically(loaded_run):
    later = "it was made 1 h after this run, and 'latest' takes only an earlier one"
    with pytest.raises(DataError, match=later):
        loaded_run(clock=SimulatedClock(START - timedelta(hours=1)))


def test_earlier_idle_run_is_preferred_to_later_one(tmp_path):
    runs, procedure = tmp_path / "runs", procedure_file(tmp_path, "idle")
    earlier = run(procedure, runs)
    run(procedure, runs, clock=SimulatedClock(START + timedelta(hours=4)))
    between = SimulatedClock(START + timedelta(hours=2))
    loaded = run(procedure_file(tmp_path, "loaded"), runs, clock=between)
    assert loaded.result.run.partners["tare"].run_id == earlier.folder.name


@pytest.mark.thorough
def test_later_idle_run_can_be_named(loaded_run, finished):
    _, idle, _ = finished
    before = SimulatedClock(START - timedelta(hours=1))
    loaded = loaded_run(clock=before, tare=idle.folder.name)
    assert loaded.result.run.partners["tare"].run_id == idle.folder.name


def test_named_idle_run_of_the_far_future_is_refused(loaded_run, finished):
    _, idle, _ = finished
    long_before = SimulatedClock(START - timedelta(days=31))
    with pytest.raises(DataError, match=r"it was made 31 d after this run, by their clocks"):
        loaded_run(clock=long_before, tare=idle.folder.name)


def test_named_run_that_does_not_fit_is_refused_with_reason(loaded_run, finished):
    _, _, loaded = finished
    with pytest.raises(DataError, match="it is a run of T-LOAD, not of T-IDLE"):
        loaded_run(tare=loaded.folder.name)
    with pytest.raises(UsageError, match="there is no run 'yesterday'"):
        loaded_run(tare="yesterday")


def test_missing_idle_run_error_says_what_is_needed(tmp_path):
    with pytest.raises(DataError, match="there is no tare run in") as caught:
        run(procedure_file(tmp_path, "loaded"), tmp_path / "none")
    assert "needed: a completed run of T-IDLE, station 'bench'" in (caught.value.hint)


def test_damaged_idle_run_is_reported_if_no_other_fits(finished, tmp_path):
    _, idle, _ = finished
    copy = tmp_path / "runs" / idle.folder.name
    copy.mkdir(parents=True)
    content = (idle.folder / "run.h5").read_bytes()
    (copy / "run.h5").write_bytes(content[: len(content) // 2])
    with pytest.raises(DataError, match=r"looked at and refused: .*it ends after"):
        run(procedure_file(tmp_path, "loaded"), tmp_path / "runs")
