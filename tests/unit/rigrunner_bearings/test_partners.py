"""A no-load run must have the rig and the torque transducer of the loaded run."""

import pytest

from helpers_workflow import FEW_FREQUENCIES, quick_procedure, run, station_file
from rigrunner.api.errors import DataError


@pytest.fixture
def loaded_run(quick_copy, tmp_path):
    """Run the loaded procedure against the quick runs, with changes."""

    def start(*changes, station=(), **options):
        procedure = quick_procedure(tmp_path, "starting_torque_1000n", *changes)
        where = station_file(tmp_path, *station) if station else None
        return run(procedure, quick_copy.folder, station=where, **options)

    return start


@pytest.mark.parametrize(
    ("changes", "station", "words"),
    [
        ((), [("mandrel: M-01", "mandrel: M-02")], "its mandrel is 'M-01', but 'M-02' is needed"),
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
    ],
)
def test_mismatched_partner_is_refused_before_the_run(loaded_run, changes, station, words):
    with pytest.raises(DataError, match=words) as caught:
        loaded_run(*changes, station=station)
    assert "run that procedure first, or name a run with --partner no_load=RUN" in caught.value.hint
