from datetime import timedelta

import pytest

from helpers_tester import both, procedure_file, run, station_file
from helpers_workflow import START
from rigrunner.api.errors import DataError, UsageError
from rigrunner.clock import SimulatedClock

pytestmark = pytest.mark.usefixtures("tester")
OWN = "same: [station], per: tester.frequency}\n      per: tester.frequency"
PLACES = ("same: [station]}", OWN), ("{of: torque, max", "{of: torque, each: tester.frequency, max")
"""The tare of each frequency of its own."""


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
        where = station_file(tmp_path, *station) if station else None
        return run(procedure, folder / "runs", station=where, **options)

    return start


def test_the_latest_fitting_idle_run_is_taken(finished):
    _, idle, loaded = finished
    assert loaded.result.run.partners["tare"].run_id == idle.folder.name


@pytest.mark.parametrize(
    ("changes", "station", "words"),
    [
        ((), [("id: bench", "id: rig-7")], "its station is 'bench', but 'rig-7'"),
        ([*PLACES, ("[8 Hz, 15 Hz,", "[8 Hz, 12 Hz,")], (), "12 Hz"),
        ([("procedure: T-IDLE", "procedure: T-XYZ")], (), "a completed run of T-XYZ"),
    ],
)
def test_a_mismatch_is_refused_before_the_run_with_what_is_needed(
    loaded_run, changes, station, words
):
    with pytest.raises(DataError, match=words) as caught:
        loaded_run(*changes, station=station)
    assert "run that procedure first, or name a run with --partner tare=RUN" in caught.value.hint


def test_an_old_idle_run_is_refused(loaded_run):
    """Of the shift before: a support that stood still overnight has another friction."""
    message = r"it is 9 h old, but at most 8 h is allowed \(max_age, .*yaml:\d+:\d+\)"
    with pytest.raises(DataError, match=message):
        loaded_run(clock=SimulatedClock(START + timedelta(hours=9)))


def test_only_an_earlier_idle_run_is_taken_by_itself(loaded_run):
    later = "it was made 1 h after this run, and 'latest' takes only an earlier one"
    with pytest.raises(DataError, match=later):
        loaded_run(clock=SimulatedClock(START - timedelta(hours=1)))


def test_of_an_earlier_and_a_later_idle_run_the_earlier_one_is_taken(tmp_path):
    runs, procedure = tmp_path / "runs", procedure_file(tmp_path, "idle")
    earlier = run(procedure, runs)
    run(procedure, runs, clock=SimulatedClock(START + timedelta(hours=4)))
    between = SimulatedClock(START + timedelta(hours=2))
    loaded = run(procedure_file(tmp_path, "loaded"), runs, clock=between)
    assert loaded.result.run.partners["tare"].run_id == earlier.folder.name


@pytest.mark.thorough
def test_a_later_idle_run_is_taken_where_it_is_named(loaded_run, finished):
    _, idle, _ = finished
    before = SimulatedClock(START - timedelta(hours=1))
    loaded = loaded_run(clock=before, tare=idle.folder.name)
    assert loaded.result.run.partners["tare"].run_id == idle.folder.name


def test_a_named_idle_run_from_far_in_the_future_is_refused(loaded_run, finished):
    _, idle, _ = finished
    long_before = SimulatedClock(START - timedelta(days=31))
    with pytest.raises(DataError, match=r"it was made 31 d after this run, by their clocks"):
        loaded_run(clock=long_before, tare=idle.folder.name)


def test_a_named_run_that_does_not_fit_is_refused_with_its_reason(loaded_run, finished):
    _, _, loaded = finished
    with pytest.raises(DataError, match="it is a run of T-LOAD, not of T-IDLE"):
        loaded_run(tare=loaded.folder.name)
    with pytest.raises(UsageError, match="there is no run 'yesterday'"):
        loaded_run(tare="yesterday")


def test_without_any_run_the_message_says_what_to_do(tmp_path):
    with pytest.raises(DataError, match="there is no tare run in") as caught:
        run(procedure_file(tmp_path, "loaded"), tmp_path / "none")
    assert "needed: a completed run of T-IDLE, station 'bench'" in (caught.value.hint)


def test_a_damaged_idle_run_is_told_where_none_is_left(finished, tmp_path):
    _, idle, _ = finished
    copied = tmp_path / "runs" / idle.folder.name
    copied.mkdir(parents=True)
    content = (idle.folder / "run.h5").read_bytes()
    (copied / "run.h5").write_bytes(content[: len(content) // 2])
    with pytest.raises(DataError, match=r"looked at and refused: .*it ends after"):
        run(procedure_file(tmp_path, "loaded"), tmp_path / "runs")
