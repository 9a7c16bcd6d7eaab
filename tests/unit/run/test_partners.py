from datetime import timedelta

import pytest

from helpers_workflow import FEW_FREQUENCIES, START, quick_procedure, run, station_file
from rigrunner.api.errors import DataError, UsageError
from rigrunner.clock import SimulatedClock


@pytest.fixture
def loaded_run(finished, tmp_path):
    """Run the loaded procedure against the runs of `finished`, with changes."""
    folder, _, _ = finished

    def start(*changes, station=(), **options):
        procedure = quick_procedure(tmp_path, "starting_torque_1000n", *changes)
        where = station_file(tmp_path, *station) if station else None
        return run(procedure, folder / "runs", station=where, **options)

    return start


def test_the_latest_fitting_no_load_run_is_taken(finished):
    _, no_load, loaded = finished
    assert loaded.result.run.partners["no_load"].run_id == no_load.folder.name


@pytest.mark.parametrize(
    ("changes", "station", "words"),
    [
        ((), [("mandrel: M-01", "mandrel: M-02")], "its mandrel is 'M-01', but 'M-02' is needed"),
        ((), [("id: simulated", "id: rig-7")], "its station is 'simulated', but 'rig-7'"),
        (
            (),
            [("serial: SIM-TQ-01", "serial: SIM-TQ-02")],
            "its torque transducer is 'SIM-TQ-01', but 'SIM-TQ-02' is needed",
        ),
        (
            (),
            [("corner: 1 kHz", "corner: 300 Hz")],
            "its low-pass filter is 'butterworth, order 2, 1000 Hz', but 'butterworth, order 2, 3",
        ),
        ((), [("eccentric: 2 mm", "eccentric: 3 mm")], "its eccentric is 2 mm, but 3 mm is needed"),
        ([(FEW_FREQUENCIES, "[8 Hz, 12 Hz]")], (), "it has no recording at 12 Hz"),
        ([("procedure: SSPB-NLI", "procedure: SSPB-XYZ")], (), "a completed run of SSPB-XYZ"),
    ],
)
def test_a_mismatch_is_refused_before_the_run_with_what_is_needed(
    loaded_run, changes, station, words
):
    with pytest.raises(DataError, match=words) as caught:
        loaded_run(*changes, station=station)
    assert "run that procedure first, or name a run with --partner no_load=RUN" in caught.value.hint


def test_an_old_no_load_run_is_refused(loaded_run):
    """Of the shift before: a support that stood still overnight has another friction."""
    told = r"it is 9 h old, but at most 8 h is allowed \(max_age, .*yaml:\d+:\d+\)"
    with pytest.raises(DataError, match=told):
        loaded_run(clock=SimulatedClock(START + timedelta(hours=9)))


def test_only_an_earlier_no_load_run_is_taken_by_itself(loaded_run):
    later = "it was made 1 h after this run, and 'latest' takes only an earlier one"
    with pytest.raises(DataError, match=later):
        loaded_run(clock=SimulatedClock(START - timedelta(hours=1)))


def test_of_an_earlier_and_a_later_no_load_run_the_earlier_one_is_taken(tmp_path):
    runs, procedure = tmp_path / "runs", quick_procedure(tmp_path, "no_load_inertia_sweep")
    earlier = run(procedure, runs)
    run(procedure, runs, clock=SimulatedClock(START + timedelta(hours=4)))
    between = SimulatedClock(START + timedelta(hours=2))
    loaded = run(quick_procedure(tmp_path, "starting_torque_1000n"), runs, clock=between)
    assert loaded.result.run.partners["no_load"].run_id == earlier.folder.name


@pytest.mark.thorough
def test_a_later_no_load_run_is_taken_where_it_is_named(loaded_run, finished):
    _, no_load, _ = finished
    before = SimulatedClock(START - timedelta(hours=1))
    loaded = loaded_run(clock=before, no_load=no_load.folder.name)
    assert loaded.result.run.partners["no_load"].run_id == no_load.folder.name


def test_a_named_no_load_run_from_far_in_the_future_is_refused(loaded_run, finished):
    _, no_load, _ = finished
    long_before = SimulatedClock(START - timedelta(days=31))
    with pytest.raises(DataError, match=r"it was made 31 d after this run, by their clocks"):
        loaded_run(clock=long_before, no_load=no_load.folder.name)


def test_a_named_run_that_does_not_fit_is_refused_with_its_reason(loaded_run, finished):
    _, _, loaded = finished
    with pytest.raises(DataError, match="it is a run of SSPB-STT-1000, not of SSPB-NLI"):
        loaded_run(no_load=loaded.folder.name)
    with pytest.raises(UsageError, match="there is no run 'yesterday'"):
        loaded_run(no_load="yesterday")


def test_without_any_run_the_message_says_what_to_do(tmp_path):
    with pytest.raises(DataError, match="there is no no-load run in") as caught:
        run(quick_procedure(tmp_path, "starting_torque_1000n"), tmp_path / "none")
    assert "needed: a completed run of SSPB-NLI, station 'simulated', mandrel 'M-01'" in (
        caught.value.hint
    )


def test_a_damaged_no_load_run_is_told_where_none_is_left(finished, tmp_path):
    _, no_load, _ = finished
    copied = tmp_path / "runs" / no_load.folder.name
    copied.mkdir(parents=True)
    whole = (no_load.folder / "run.h5").read_bytes()
    (copied / "run.h5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DataError, match=r"looked at and refused: .*it ends after"):
        run(quick_procedure(tmp_path, "starting_torque_1000n"), tmp_path / "runs")
