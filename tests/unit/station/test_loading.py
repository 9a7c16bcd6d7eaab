"""Shipped stations load; an invalid one is refused with location, field and message."""

from __future__ import annotations

from pathlib import Path

import pytest

from helpers_language import STATION, edited, only_problem, place_of, problems_of
from rigrunner.station import InconsistentStationError, load_station, parse_station

SHIPPED = Path(__file__).parents[3] / "procedures" / "stations"

SECOND = """
  - channel: tester.torque
    serial: T-2
    full_scale: 10 N·m
    accuracy: {gain: 0 %, offset: 0 N·m, drift: 0 N·m, nonlinearity: 0 %}
"""

# old part, new part, text at the location, field, message, hint
CASES = [
    ("station/1", "procedure/2", "procedure/2", "rigrunner",
     "got 'procedure/2', expected 'station/1'", ""),
    ("id: bench-1", "id: bench 1", "bench 1", "id", "'bench 1' is not an id", ""),
    ("mandrel: M-01", "mandrel: 01", "01", "rig.mandrel", "01 has a leading zero",
     "write 1 for the number, or '01' in quotes for the text"),
    ("    plugin: fake\n", "", "tester:", "devices.tester.plugin",
     "the key 'plugin' is missing", ""),
    ("settings: {gain: 1 N·m}", "settings: fast", "fast", "devices.tester.settings",
     "got 'fast', expected a mapping of names to values", ""),
    ("  tester:\n", "  the tester:\n", "the tester", "devices.the tester",
     "'the tester' is not a name", ""),
    ("channel: tester.torque", "channel: testre.torque", "testre.torque", "instruments[0].channel",
     "there is no device in the role 'testre'", "did you mean 'tester'?"),
    ("channel: tester.torque", "channel: torque", "torque\n", "instruments[0].channel",
     "'torque' is not of the form role.name, such as tester.torque", ""),
    ("serial: T-1", "serial: 17", "17", "instruments[0].serial", "got 17, expected a text",
     "put it in quotes: '17'"),
    ("full_scale: 10 N·m", "full_scale: 10 Nm/s", "10 Nm/s", "instruments[0].full_scale",
     "got '10 N·m/s', a torque rate, expected a torque", ""),
    ("full_scale: 10 N·m", "full_scale: 10 N·m\n    due: 2026-02-30", "2026-02-30",
     "instruments[0].due", "'2026-02-30' is not a date; write it as 2026-01-31", ""),
    ("gain: 0.3 %", "gain: 0.003", "0.003", "instruments[0].accuracy.gain",
     "0.003 is not a number with a unit", "such as '0.5 % FS'"),
    ("order: 2", "order: 9", "9,", "instruments[0].low_pass.order",
     "got 9, expected 8 or less", ""),
    ("butterworth", "elliptic", "elliptic", "instruments[0].low_pass.type",
     "got 'elliptic', expected 'butterworth', 'bessel' or 'chebyshev'", ""),
]  # fmt: skip


@pytest.mark.parametrize("path", sorted(SHIPPED.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_stations_load(path):
    assert load_station(path).model.id == path.stem


def test_station_has_the_content_of_its_file():
    station = parse_station(STATION, "s.yaml")

    assert station.model.devices["tester"].settings == {"gain": "1 N·m"}
    assert station.model.rig["eccentric"] == "2 mm"
    assert station.register["tester.torque"].low_pass.corner == 1000.0
    assert parse_station(station.text, "run.h5").digest == station.digest


@pytest.mark.parametrize("case", CASES, ids=lambda case: (case[1] or case[0])[:30])
def test_invalid_station_is_refused_with_its_location(case):
    old, new, located, field, message, hint = case
    text = edited(STATION, (old, new))
    problem = only_problem(parse_station, text, "s.yaml")

    assert message in problem.message
    assert problem.field == field
    assert hint in problem.hint
    assert str(problem.location) == f"s.yaml:{place_of(text, located)}"


def test_second_instrument_of_a_channel_is_refused():
    problem = only_problem(parse_station, STATION.rstrip() + SECOND, "s.yaml")

    assert problem.message == "'tester.torque' is registered twice"
    assert problem.field == "instruments[1].channel"


def test_all_problems_are_reported_at_once():
    text = edited(STATION, ("10 N·m", "10"), ("1 kHz", "1"))
    assert len(problems_of(parse_station, text, "s.yaml")) == 2


def test_invalid_accuracy_of_any_quantity_is_one_problem():
    meter = "  - {channel: tester.voltage, measures: voltage, serial: V-1, accuracy: 1 vlt}\n"
    problem = only_problem(parse_station, STATION.rstrip() + f"\n{meter}", "s.yaml")
    assert problem.field == "instruments[1].accuracy"
    assert problem.message.startswith("unknown unit 'vlt'")


def test_unknown_quantity_is_one_problem():
    meter = "  - {channel: tester.amps, measures: amps, serial: A-1, calibration: recorded}\n"
    problem = only_problem(parse_station, STATION.rstrip() + f"\n{meter}", "s.yaml")
    assert (problem.field, problem.message) == (
        "instruments[1].measures",
        "'amps' is not a quantity",
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("instruments:\n", "instruments:\n  - fast\n"), "got 'fast', expected a mapping"),
        (("    accuracy: {gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}\n",
          ""), "the key 'accuracy' is missing"),
        (("serial: T-1", "serial: T-1\n    calibrated: 2026-02-01\n    due: 2026-01-01"),
         "calibrated (2026-02-01) must not be after due (2026-01-01)"),
    ],
)  # fmt: skip
def test_station_with_a_wrong_instrument_is_checked_further(change, message):
    """The plan is then checked with a replacement, and all problems are reported at once."""
    with pytest.raises(InconsistentStationError) as caught:
        parse_station(edited(STATION, change), "s.yaml")
    (problem,) = caught.value.problems
    assert (problem.field, problem.message[: len(message)]) == ("instruments[0]", message)
    assert caught.value.loaded.model.id == "bench-1"


def test_problem_that_no_replacement_solves_is_reported_once():
    text = edited(STATION, ("    full_scale: 10 N·m\n", ""))
    problem = only_problem(parse_station, text, "s.yaml")
    assert problem.field == "instruments[0]"
    assert problem.message.startswith("the key 'full_scale' is missing, or a 'range'")
